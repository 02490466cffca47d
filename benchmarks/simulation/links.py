"""What cooperation is worth: E of teams whose agents plan each for itself, over range, loss and delay of their links.

python benchmarks/simulation/links.py information swept_information --trials 60                    # generated streets
SOONER_DATA=... python benchmarks/simulation/links.py information --trials 60 --authors            # the authors' maps

Seeds are the same for all links, so that they are compared trial by trial with one command post that hears all at once,
which is what perfect links come to.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sooner.io import read_street_map
from sooner.scenarios import STREET_KINDS, street_grid
from sooner.simulation import Estimator, Links, Scene, World, simulate
from sooner.simulation.strategies import make_strategy

MAPS = ("authors_map1_randalls_island", "authors_map2_silver_spring", "authors_map3_nyc")
PERFECT = "one command post"
LINKS = {
    PERFECT: None,
    **{f"range {metres:g} m": Links(range_m=metres) for metres in (100.0, 50.0, 25.0, 0.0)},
    **{f"loss {loss:g}": Links(loss=loss) for loss in (0.3, 0.6, 0.9)},
    **{f"delay {seconds} s": Links(delay_s=seconds) for seconds in (2, 5, 15)},
}


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("strategies", nargs="+")
    asked.add_argument("--trials", type=int, default=60)
    asked.add_argument("--first", type=int, default=9000, help="the first seed")
    asked.add_argument("--authors", action="store_true", help="the maps of [Wolek2020]; else generated ones")
    asked.add_argument("--prior", default="kriged")
    asked.add_argument("--links", action="append", help="beginning of a row's name; all if left out")
    flags = asked.parse_args()
    worlds = [World(graph) for graph in (_authors() if flags.authors else _generated())]
    print("| strategy | links | E | E, change | E_nodes | E_nodes, change | by all | false calls | CPU ms a trial |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in flags.strategies:
        at_once: NDArray[np.float64] | None = None
        for told, links in LINKS.items():
            if flags.links and told != PERFECT and not any(told.startswith(wish) for wish in flags.links):
                continue
            flown, spent = _flown(worlds, name, flags, links)
            at_once = flown if at_once is None else at_once
            print(_row(name, told, flown, flown - at_once, spent), flush=True)


def _flown(
    worlds: list[World], name: str, flags: argparse.Namespace, links: Links | None
) -> tuple[NDArray[np.float64], float]:
    """(trials, 4) float: E, E_nodes, E_nodes where all must know, false calls; and CPU seconds a trial."""
    scenes = [Scene(world, estimator=Estimator(prior=flags.prior), links=links) for world in worlds]
    for scene in scenes:
        simulate(scene, make_strategy(name), 10**6)  # compiles, and makes what a scene makes once
    began, rows = time.process_time(), []
    for seed in range(flags.first, flags.first + flags.trials):
        episode = simulate(scenes[seed % len(scenes)], make_strategy(name), seed)
        rows.append((episode.e, episode.e_nodes, episode.e_nodes_by_all, episode.false_calls))
    return np.array(rows), (time.process_time() - began) / flags.trials


def _row(name: str, links: str, flown: NDArray[np.float64], apart: NDArray[np.float64], spent: float) -> str:
    cells = [name, links, _told(flown[:, 0]), _told(apart[:, 0], "+"), _told(flown[:, 1]), _told(apart[:, 1], "+", 4)]
    return f"| {' | '.join(cells)} | {flown[:, 2].mean():.3f} | {flown[:, 3].mean():.2f} | {1e3 * spent:.0f} |"


def _told(values: NDArray[np.float64], sign: str = "", digits: int = 3) -> str:
    error = values.std(ddof=1) / np.sqrt(len(values))
    return f"{values.mean():{sign}.{digits}f} +- {error:.{digits}f}"


def _generated():
    return [street_grid(kind, 700 + n) for n in range(2) for kind in STREET_KINDS]


def _authors():
    folder = Path(os.environ["SOONER_DATA"]) / "occupancy_graphs"
    return [read_street_map(folder / f"{name}.graph.json").graph for name in MAPS]


if __name__ == "__main__":
    main()
