"""SAREnv's baselines drawn anew from their published geometry, for what they truly sweep.

Its evaluator's figures come without paths. A pitch of 2 r, points every 10 m, rings joined over 50 m, sectors kept
15 m apart, and cut off at the budget: so drawn they score as SAREnv says, to the digits of the table in README.md.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sooner.experiments.sarenv import Sarenv

Way = NDArray[np.float64]

POINT_M = 10.0  # between the points of a curve
STEP_OVER_M = 50.0  # of a ring left out to step over to the next
SECTOR_GAP_M = 15.0  # between the turns of a sector and its border


def spiral(scenario: Sarenv, drones: int, metres: float) -> list[Way]:
    """An Archimedean spiral out of the centre; several drones fly a piece each."""
    pitch, most = 2 * scenario.radius_m, _reach(scenario)
    turns = most / pitch
    angle = np.linspace(0, 2 * np.pi * turns, int(np.pi * turns * most / POINT_M))
    return _pieces(_polar(scenario, pitch / (2 * np.pi) * angle, angle), drones, metres)


def concentric(scenario: Sarenv, drones: int, metres: float) -> list[Way]:
    """Rings from the inside out; several drones fly a piece each."""
    pitch, most = 2 * scenario.radius_m, _reach(scenario)
    rings = []
    for radius in np.arange(pitch, most + 1e-9, pitch):
        last = radius + pitch > most
        end = 2 * np.pi - (0.0 if last else STEP_OVER_M / radius)
        angle = np.linspace(0, end, max(2, int(radius * end / POINT_M)))
        rings.append(_polar(scenario, np.full(len(angle), radius), angle))
    return _pieces(np.concatenate(rings), drones, metres)


def pizza(scenario: Sarenv, drones: int, metres: float) -> list[Way]:
    """A sector for each drone, swept in arcs to and fro from the centre out."""
    pitch, most = 2 * scenario.radius_m, _reach(scenario)
    ways = []
    for drone in range(drones):
        low, high = 2 * np.pi * drone / drones, 2 * np.pi * (drone + 1) / drones
        arcs = [np.array([scenario.centre])]
        for ring, radius in enumerate(np.arange(pitch, most + 1e-9, pitch)):
            gap = SECTOR_GAP_M / radius
            angle = np.linspace(low + gap, high - gap, max(2, int(radius * (high - low - 2 * gap) / POINT_M)))
            arcs.append(_polar(scenario, np.full(len(angle), radius), angle if ring % 2 == 0 else angle[::-1]))
        ways.append(_cut(np.concatenate(arcs), metres / drones))
    return ways


def greedy(scenario: Sarenv, drones: int, metres: float, seed: int = 0) -> list[Way]:
    """To the one of the eight cells around from which most heat comes into view that nobody has seen; ties by lot.

    Drones take turns; all but the first begin up to two cells away from the centre.
    """
    rng = np.random.default_rng(seed)
    height, width = scenario.heat.shape
    unseen = scenario.heat[::-1].copy()  # rows from the south, as y grows
    angles = 2 * np.pi * np.arange(drones) / drones
    offsets = np.trunc(2 * np.column_stack([np.sin(angles), np.cos(angles)])).astype(int)
    offsets[0] = 0
    here = np.array([height // 2, width // 2]) + offsets
    ways = [[cell.copy()] for cell in here]
    reach = int(np.ceil(scenario.radius_m / scenario.cell_m))
    view = [step for step in _steps(reach) if np.hypot(*step) * scenario.cell_m <= scenario.radius_m]

    def in_view(cell: NDArray[np.int64]) -> tuple[NDArray[np.int64], ...]:
        cells = cell + np.array(view)
        return tuple(cells[((cells >= 0) & (cells < (height, width))).all(axis=1)].T)

    for cell in here:
        unseen[in_view(cell)] = 0.0
    around = [step for step in _steps(1) if step.any()]
    for _ in range(int(metres // scenario.cell_m) // drones):
        for drone in range(drones):
            near = [cell for step in around if _inside(scenario, cell := here[drone] + step)]
            here[drone] = max(near, key=lambda cell: (unseen[in_view(cell)].sum(), rng.random()))
            ways[drone].append(here[drone].copy())
            unseen[in_view(here[drone])] = 0.0
    return [_cut(np.array(way, float)[:, ::-1] * scenario.cell_m, metres / drones) for way in ways]


def _steps(reach: int) -> list[NDArray[np.int64]]:
    return [np.array((up, right)) for up in range(-reach, reach + 1) for right in range(-reach, reach + 1)]


PATTERNS: dict[str, Callable[[Sarenv, int, float], list[Way]]] = {
    "Spiral": spiral,
    "Concentric": concentric,
    "Pizza": pizza,
    "Greedy": greedy,
}


def _reach(scenario: Sarenv) -> float:
    return scenario.heat.shape[1] * scenario.cell_m / 2


def _inside(scenario: Sarenv, cell: NDArray[np.int64]) -> bool:
    height, width = scenario.heat.shape
    if not (0 <= cell[0] < height and 0 <= cell[1] < width):
        return False
    away = np.asarray(cell[::-1]) * scenario.cell_m - np.array(scenario.centre)
    return bool(np.hypot(*away) <= _reach(scenario))


def _polar(scenario: Sarenv, radius: NDArray[np.float64], angle: NDArray[np.float64]) -> Way:
    return np.array(scenario.centre) + np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def _pieces(way: Way, drones: int, metres: float) -> list[Way]:
    """One way cut into pieces as long as each other, each flown as far as the budget goes."""
    from_m = np.linspace(0, _passed(way)[-1], drones + 1)
    return [_between(way, a, min(b, a + metres / drones)) for a, b in pairwise(from_m)]


def _cut(way: Way, metres: float) -> Way:
    return _between(way, 0.0, min(metres, _passed(way)[-1]))


def _between(way: Way, start: float, stop: float) -> Way:
    passed = _passed(way)
    inner = way[(passed > start) & (passed < stop)]
    ends = np.column_stack([np.interp([start, stop], passed, way[:, axis]) for axis in (0, 1)])
    return np.concatenate([ends[:1], inner, ends[1:]])


def _passed(way: Sequence[float] | Way) -> NDArray[np.float64]:
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(np.asarray(way), axis=0).T))])
