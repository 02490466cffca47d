"""The search posed as a prize-collecting routing problem and given to PyVRP: the bar that a planner must clear.

Nodes of a square lattice are clients, the heat of the square around each its prize, so that none counts twice; every
drone is a vehicle with a longest way, from the centre and back. What comes into view between two nodes that are not
next to each other is not in the model; scores are of the way flown, so they may be more than the model knew.
"""

from __future__ import annotations

import time
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.experiments.sarenv import Sarenv

Way = NDArray[np.float64]

UNIT_M = 0.1  # PyVRP counts in whole numbers
PRIZES = 100_000  # of the best node, in units of distance: a node is worth a detour long before that
CLIENTS = 1.4  # best nodes for each that fits in the budget: fewer leave no choice, more only slow PyVRP down


def route(scenario: Sarenv, drones: int, metres: float, pitch_m: float, seconds: float, seed: int = 0) -> list[Way]:
    """One way for each drone, each at most metres / drones long with its return, after that much processor time."""
    from pyvrp import Client, Depot, Location, ProblemData, VehicleType, solve
    from pyvrp.exceptions import PenaltyBoundWarning

    until = time.process_time() + seconds
    nodes, heat = lattice(scenario, pitch_m)
    within = np.hypot(*(nodes - scenario.centre).T) <= metres / drones / 2
    best = np.argsort(-np.where(within, heat, 0.0), kind="stable")[: int(CLIENTS * metres / pitch_m)]
    best = best[(heat[best] > 1e-9) & within[best]]
    places = np.concatenate([[scenario.centre], nodes[best]])
    prizes = np.maximum(np.rint(heat[best] / heat.max() * PRIZES), 1).astype(int)
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    units = np.ceil(apart / UNIT_M).astype(np.int64)
    data = ProblemData(
        [Location(*place) for place in places],
        [Client(location=n, prize=int(prize), required=False) for n, prize in enumerate(prizes, 1)],
        [Depot(location=0)],
        [VehicleType(drones, max_distance=int(metres / drones / UNIT_M), unit_distance_cost=1)],
        [units],
        [np.zeros_like(units)],
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PenaltyBoundWarning)
        result = solve(data, lambda _: time.process_time() >= until, seed=seed, collect_stats=False, display=False)
    if not result.best.is_feasible():
        raise RuntimeError("PyVRP found no tour within the budget")
    return [_way(scenario, nodes[best], tour) for tour in result.best.routes()]


def lattice(scenario: Sarenv, pitch_m: float) -> tuple[Way, NDArray[np.float64]]:
    """(n, 2) nodes and (n,) the heat of the square around each. A pitch of three cells has its nodes on their centres.

    Other lattices have a node in the middle of the scenario.
    """
    height, width = scenario.heat.shape
    cell = scenario.cell_m
    on_centres = abs(pitch_m / cell - round(pitch_m / cell)) < 1e-9 and round(pitch_m / cell) % 2 == 1
    middle = np.array(scenario.centre)
    if on_centres:
        middle = np.rint(middle / cell) * cell
    reach = int(np.ceil(max(height, width) * cell / pitch_m / 2)) + 1
    steps = np.arange(-reach, reach + 1) * pitch_m
    east, north = middle[0] + steps, middle[1] + steps
    up, right = shares(height, cell, north, pitch_m), shares(width, cell, east, pitch_m)
    heat = up @ scenario.heat[::-1] @ right.T
    return np.stack(np.meshgrid(east, north), axis=-1).reshape(-1, 2), heat.ravel()


def shares(cells: int, cell_m: float, nodes: NDArray[np.float64], pitch_m: float) -> NDArray[np.float64]:
    """(n, cells) share of each cell, along one axis, that belongs to the strip around each node."""
    low, high = (np.arange(cells) - 0.5) * cell_m, (np.arange(cells) + 0.5) * cell_m
    inside = np.minimum(high, nodes[:, None] + pitch_m / 2) - np.maximum(low, nodes[:, None] - pitch_m / 2)
    return np.asarray(np.clip(inside, 0.0, None) / cell_m)


def _way(scenario: Sarenv, nodes: Way, tour: Any) -> Way:
    stops = [nodes[activity.idx] for activity in tour if activity.is_client()]
    return np.array([scenario.centre, *stops, scenario.centre], float)
