"""Several targets: a track of its own for each that is found, against one tracker that is restarted after each call.

python benchmarks/simulation/targets.py --maps 8 --trials 10 --first 900              # generated streets, of each kind
SOONER_DATA=... python benchmarks/simulation/targets.py --trials 100                  # the three maps of [Wolek2020]
SOONER_DATA=... python benchmarks/simulation/targets.py --trials 100 --prior known    # which are known beforehand

The same seeds for all, so that differences are of pairs: targets, starts and readings are the same. In time until all
are found, a search that does not find all counts as long as the mission. Others in view: 300 more targets walk about
that nobody looks for, and what is told is the mean second in which one is in view for the second time; it has far less
noise. "unaware": the tracker is restarted, and the strategy is not told, so that its own belief of where the target is
goes on.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sooner.io import read_street_map
from sooner.scenarios import STREET_KINDS, street_grid
from sooner.simulation import Episode, Estimator, Scene, World, simulate
from sooner.simulation.strategies import Strategy, make_strategy
from sooner.streets import OccupancyGraph

MAPS = ("authors_map1_randalls_island", "authors_map2_silver_spring", "authors_map3_nyc")
MEASURES = (
    "all found after s",
    "share found",
    "E_targ",
    "E",
    "false calls",
    "repeated calls",
    "others in view after s",
)
WALKERS, LOOKS = 300, 2
WAYS, UNAWARE = ("restarted", "each"), "unaware"


@dataclass(frozen=True)
class Unaware:
    """A strategy whose sessions are not told of targets that were found."""

    strategy: Strategy

    @property
    def capture(self) -> float:
        return self.strategy.capture

    def starts(self, grid, agents, drawn):
        return self.strategy.starts(grid, agents, drawn)

    def session(self, situation, rng):
        session = self.strategy.session(situation, rng)
        session.found = None
        return session


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--maps", type=int, default=0, help="generated maps of each kind; 0 for the authors' maps")
    asked.add_argument("--trials", type=int, default=50, help="on each map")
    asked.add_argument("--first", type=int, default=0, help="the first seed, of maps and of trials")
    asked.add_argument("--targets", type=int, nargs="+", default=[2, 3])
    asked.add_argument("--strategies", nargs="+", default=["information", "joint"])
    asked.add_argument("--prior", default="kriged", help="of the streets")
    asked.add_argument(
        "--ways", nargs="+", default=WAYS, help="how targets are tracked; differences are from the first"
    )
    said = asked.parse_args()
    graphs = list(_graphs(said.maps, said.first))
    print(f"| targets | strategy | tracks | {' | '.join(MEASURES)} | CPU ms |")
    print("|---" * (len(MEASURES) + 4) + "|")
    for n_targets in said.targets:
        for strategy in said.strategies:
            first = None
            for way in said.ways:
                began = time.process_time()
                seeds = range(said.first, said.first + said.trials)
                flying, tracks = make_strategy(strategy), way
                if way == UNAWARE:
                    flying, tracks = Unaware(flying), "restarted"
                estimator = Estimator(prior=said.prior, tracks=tracks)
                scenes = [Scene(World(graph, n_targets=n_targets), estimator=estimator) for graph in graphs]
                rows = np.array([flown(scene, flying, seed) for scene in scenes for seed in seeds])
                spent = 1e3 * (time.process_time() - began) / len(rows)
                print(f"| {n_targets} | {strategy} | {way} | {_told(rows)} | {spent:.0f} |", flush=True)
                if first is None:
                    first = rows
                else:
                    print(f"| | | {way} - {said.ways[0]} | {_told(rows - first)} | |", flush=True)


def _graphs(maps: int, first: int) -> Iterator[OccupancyGraph]:
    if maps:
        yield from (street_grid(kind, first + n) for kind in STREET_KINDS for n in range(maps))
        return
    folder = Path(os.environ["SOONER_DATA"]) / "occupancy_graphs"
    yield from (read_street_map(folder / f"{name}.graph.json").graph for name in MAPS)


def flown(scene: Scene, strategy: Strategy, seed: int) -> tuple[float, ...]:
    """What one trial measures, in the order of `MEASURES`."""
    episode = simulate(scene, strategy, seed)
    found = episode.found_targets
    last = found.max() if (found >= 0).all() else episode.seconds
    share = float((found >= 0).mean())
    calls = episode.false_calls, episode.repeated_calls
    return float(last), share, episode.e_targets, episode.e, *calls, _others_in_view(episode)


def _others_in_view(episode: Episode) -> float:
    world, rng = episode.scene.world, np.random.default_rng(episode.seed)
    walked = world.walk.walked(world.states, world.walk.started(world.states, rng, WALKERS), episode.seconds, rng)
    centres = world.grid.centres_m[world.graph.cells[world.states.current[walked]]][:-1]  # (T, WALKERS, 2)
    apart = np.linalg.norm(centres[:, :, None] - episode.places_m[:-1, None], axis=-1)
    looks = np.cumsum((apart <= episode.scene.sensing.radius_m).any(axis=-1), axis=0) >= LOOKS
    return float(np.where(looks.any(axis=0), looks.argmax(axis=0), episode.seconds).mean())


def _told(rows: NDArray[np.float64]) -> str:
    errors = rows.std(axis=0, ddof=1) / np.sqrt(len(rows))
    return " | ".join(f"{mean:.3f} +- {error:.3f}" for mean, error in zip(rows.mean(axis=0), errors, strict=True))


if __name__ == "__main__":
    main()
