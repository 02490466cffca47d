"""Strategies on generated streets, paired trial by trial with the first: the ground on which settings are chosen.

python benchmarks/simulation/paired.py tuned_lawnmower joint joint:rounds=3 joint:target=1.0 --maps 8 --first 300

There is no target to be called: 300 that walk are followed afterwards, and one counts as found at the second second in
which it is in view. So the target's half of E is not that of an episode, but has far less noise.
"""

from __future__ import annotations

import argparse

import numpy as np
from numpy.typing import NDArray

from sooner.scenarios import STREET_KINDS, street_grid
from sooner.simulation import Episode, Estimator, Scene, World, simulate
from sooner.simulation.strategies import make_strategy

WALKERS, LOOKS = 300, 2


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("strategies", nargs="+", help="name, or name:setting=number,setting=number")
    asked.add_argument("--maps", type=int, default=8, help="of each kind")
    asked.add_argument("--first", type=int, default=300, help="the first map's seed")
    asked.add_argument("--prior", default="kriged")
    flags = asked.parse_args()
    graphs = [street_grid(kind, flags.first + n) for kind in STREET_KINDS for n in range(flags.maps)]
    before: NDArray[np.float64] | None = None
    for text in flags.strategies:
        name, _, rest = text.partition(":")
        settings = {key: _number(value) for key, value in (part.split("=") for part in rest.split(",") if part)}
        halves = np.array(
            [_flown(graph, name, settings, 5000 + 100 * n, flags.prior) for n, graph in enumerate(graphs)]
        )
        line = f"{text:40s} nodes {_told(halves[:, 0])}  targets {_told(halves[:, 1])}"
        if before is not None:
            apart = halves - before
            line += f"  apart: nodes {_told(apart[:, 0])}  both {_told(apart.sum(axis=1))}"
        before = halves if before is None else before
        print(line, flush=True)


def _flown(graph, name, settings, seed, prior):
    episode = simulate(
        Scene(World(graph, n_targets=0), estimator=Estimator(prior=prior)), make_strategy(name, **settings), seed
    )
    return episode.e_nodes, _walkers_found(World(graph), episode)


def _walkers_found(world: World, episode: Episode) -> float:
    """Half the mean share of the mission that is left when a walker is found."""
    rng = np.random.default_rng(1)
    walked = world.walk.walked(world.states, world.walk.started(world.states, rng, WALKERS), episode.seconds, rng)
    centres = world.grid.centres_m[world.graph.cells[world.states.current[walked]]][:-1]  # (T, WALKERS, 2)
    apart = np.linalg.norm(centres[:, :, None] - episode.places_m[:-1, None], axis=-1)
    looks = np.cumsum((apart <= episode.scene.sensing.radius_m).any(axis=-1), axis=0) >= LOOKS
    found = np.where(looks.any(axis=0), looks.argmax(axis=0), episode.seconds)
    return float(0.5 * (1.0 - found / episode.seconds).mean())


def _told(values: NDArray[np.float64]) -> str:
    return f"{values.mean():+.4f} +- {values.std(ddof=1) / np.sqrt(len(values)):.4f}"


def _number(text: str) -> float | int:
    return float(text) if "." in text else int(text)


if __name__ == "__main__":
    main()
