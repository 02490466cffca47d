"""Unlike agents, and ground where looks are often in vain: what it is worth that plans know, paired trial by trial.

python benchmarks/simulation/unlike.py team                          # a mixed team, planned as it is, or as if equal
python benchmarks/simulation/unlike.py occluded                      # a patch of canopy, known to the planner or not
SOONER_DATA=... python benchmarks/simulation/unlike.py team --maps authors --trials 100

Flights are flown with the true bodies, sensors and canopy throughout, and beliefs know them: only plans differ.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.io import read_street_map
from sooner.scenarios import STREET_KINDS, street_grid
from sooner.sensors import GradedSensor
from sooner.simulation import Agent, Estimator, Scene, World, simulate
from sooner.simulation.strategies import make_strategy
from sooner.simulation.strategies.strategy import Routes, Session, Situation, Strategy
from sooner.streets import OccupancyGraph

MAPS = ("authors_map1_randalls_island", "authors_map2_silver_spring", "authors_map3_nyc")
Floats = NDArray[np.float64]


def agent(v_max: float, a_max: float, radius_m: float, sensitivity: float) -> Agent:
    return Agent(v_max, a_max, radius_m, GradedSensor(sensitivity), GradedSensor(sensitivity))


QUICK, SLOW = agent(5.0, 3.0, 8.0, 2.0), agent(2.0, 1.5, 17.5, 5.0)
TEAMS = {
    "two quick that see little, two slow that see much": (QUICK, QUICK, SLOW, SLOW),
    "two quick, two slow, alike but for that": (agent(5.0, 3.0, 12.5, 4.0),) * 2 + (agent(1.5, 1.0, 12.5, 4.0),) * 2,
    "radius 6 and 19 m, alike but for that": (agent(3.0, 2.0, 6.0, 4.0),) * 2 + (agent(3.0, 2.0, 19.0, 4.0),) * 2,
    "sensitivity 1.2 and 5, alike but for that": (agent(3.0, 2.0, 12.5, 1.2),) * 2 + (agent(3.0, 2.0, 12.5, 5.0),) * 2,
}
STRATEGIES = ("information", "swept_information", "rollouts", "joint")


def patch(share: float, rows: slice, cols: slice, side: int = 40) -> Floats:
    """Ground of which one patch lies under canopy."""
    glimpse = np.ones((side, side))
    glimpse[rows, cols] = share
    return glimpse


CANOPIES = {
    "a quarter under canopy, g = 0.2": patch(0.2, slice(10, 30), slice(10, 30)),
    "the western half under canopy, g = 0.2": patch(0.2, slice(0, 40), slice(0, 20)),
    "a quarter that cannot be seen": patch(0.0, slice(10, 30), slice(10, 30)),
}


def mean_agent(agents: tuple[Agent, ...]) -> Agent:
    """The agent that is in all numbers the mean of a team."""
    numbers = [(a.v_max, a.a_max, a.radius_m, a.map_sensor.sensitivity, a.target_sensor.sensitivity) for a in agents]
    v_max, a_max, radius_m, g, z = np.mean(numbers, axis=0).tolist()
    return Agent(v_max, a_max, radius_m, GradedSensor(g), GradedSensor(z))


@dataclass(frozen=True)
class AsIf:
    """A strategy that is told of other agents, or of other ground, than there are."""

    strategy: Strategy
    changed: dict[str, Any]

    @property
    def capture(self) -> float:
        return self.strategy.capture

    def starts(self, grid: Grid, agents: tuple[Agent, ...], drawn: Floats) -> Floats:
        return self.strategy.starts(grid, self.changed.get("agents", agents), drawn)

    def session(self, situation: Situation, rng: Generator) -> Session:
        session = self.strategy.session(replace(situation, **self.changed), rng)
        return _Misled(session, self.changed)


class _Misled:
    def __init__(self, session: Session, changed: dict[str, Any]) -> None:
        self.session, self.changed = session, changed
        if hasattr(session, "watch"):
            self.watch = session.watch

    def routes(self, situation: Situation) -> Routes:
        return self.session.routes(replace(situation, **self.changed))


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("what", choices=("team", "occluded"))
    asked.add_argument("--maps", choices=("generated", "authors"), default="generated")
    asked.add_argument("--trials", type=int, default=50, help="on each kind of map, or on each map")
    asked.add_argument("--first", type=int, default=700, help="the first seed, and the first map's")
    asked.add_argument("--strategy", action="append", help="all if left out")
    asked.add_argument("--case", type=int, action="append", help="number of a team or canopy, from 0; all if left out")
    asked.add_argument("--prior", default="kriged")
    said = asked.parse_args()
    if said.what == "team":
        for number, (name, agents) in enumerate(TEAMS.items()):
            if said.case and number not in said.case:
                continue
            equal = {"agents": (mean_agent(agents),) * len(agents)}
            _compare(name, "as if equal", {"agents": agents}, equal, said)
    else:
        for number, (name, glimpse) in enumerate(CANOPIES.items()):
            if said.case and number not in said.case:
                continue
            _compare(name, "as if open", {"glimpse": glimpse}, {"glimpse": None}, said)


def _compare(name: str, blindly: str, scene: dict[str, Any], changed: dict[str, Any], said: argparse.Namespace) -> None:
    print(f"\n{name}\n")
    print(f"| strategy | E | E, planned {blindly} | apart | nodes apart | targets apart | n |")
    print("|---|---|---|---|---|---|---|", flush=True)
    for strategy in said.strategy or STRATEGIES:
        told = make_strategy(strategy)
        pairs = []
        for world, seed in _worlds(said):
            ground = Scene(world, estimator=Estimator(prior=said.prior), **scene)
            pairs.append([_flown(ground, each, seed) for each in (told, AsIf(told, changed))])
        print("|", strategy, "|", _told(np.array(pairs)), flush=True)


def _worlds(said):
    for n in range(said.trials):
        for graph in _graphs(said, n):
            yield World(graph), said.first + n


def _graphs(said, n) -> list[OccupancyGraph]:
    if said.maps == "generated":
        return [street_grid(kind, said.first + n) for kind in STREET_KINDS]
    folder = Path(os.environ["SOONER_DATA"]) / "occupancy_graphs"
    return [read_street_map(folder / f"{name}.graph.json").graph for name in MAPS]


def _flown(scene: Scene, strategy: Strategy, seed: int) -> tuple[float, float]:
    episode = simulate(scene, strategy, seed)
    return episode.e_nodes, episode.e_targets


def _told(pairs: Floats) -> str:
    """(n, 2, 2): trials, told or not, halves of E."""
    halves = pairs[:, 0] - pairs[:, 1]
    columns = [*pairs.sum(axis=2).T, halves.sum(axis=1), *halves.T]
    texts = [f"{c.mean():+.4f} +- {c.std(ddof=1) / np.sqrt(len(c)):.4f}" for c in columns]
    return " | ".join(texts) + f" | {len(pairs)} |"


if __name__ == "__main__":
    main()
