"""Strategies on the maps that only judge, paired trial by trial with the first; settings are chosen on other streets.

SOONER_DATA=... python benchmarks/simulation/ablation.py joint:start=chosen joint tuned_lawnmower --trials 100
SOONER_DATA=... python benchmarks/simulation/ablation.py joint --oakland --trials 150 --to flown.csv --with before.csv

Each trial goes to the file of `--to`; `--with` takes strategies from such files, which another version may have flown.
"""

from __future__ import annotations

import argparse
import csv
import os
import time
from pathlib import Path

import numpy as np

from sooner.io import read_street_map
from sooner.simulation import Estimator, Scene, World, simulate
from sooner.simulation.strategies import make_strategy

AUTHORS = ("authors_map1_randalls_island", "authors_map2_silver_spring", "authors_map3_nyc")
OAKLAND = ("west_oakland_gridiron",)


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("strategies", nargs="*", help="name, or name:setting=value,setting=value")
    asked.add_argument("--trials", type=int, default=100, help="on each map")
    asked.add_argument("--first", type=int, default=1000, help="the first seed")
    asked.add_argument("--prior", default="kriged")
    asked.add_argument("--oakland", action="store_true", help="West Oakland instead of the authors' maps")
    asked.add_argument("--to", type=Path)
    asked.add_argument("--with", dest="others", type=Path, action="append", default=[])
    said = asked.parse_args()
    names = OAKLAND if said.oakland else AUTHORS
    flown = {
        text: fly(text, names, range(said.first, said.first + said.trials), said.prior) for text in said.strategies
    }
    for path in said.others:
        flown.update(read(path))
    if said.to:
        write(said.to, flown)
    show(flown)


def fly(text: str, names: tuple[str, ...], seeds: range, prior: str) -> np.ndarray:
    """(trials, 3) E_nodes, E_targets and CPU seconds, map by map."""
    name, _, rest = text.partition(":")
    strategy = make_strategy(name, **dict(setting(part) for part in rest.split(",") if part))
    rows = []
    for each in names:
        folder = Path(os.environ["SOONER_DATA"]) / "occupancy_graphs"
        scene = Scene(World(read_street_map(folder / f"{each}.graph.json").graph), estimator=Estimator(prior=prior))
        simulate(scene, strategy, 10**6)  # compiles, and makes what a scene makes once
        for seed in seeds:
            began = time.process_time()
            episode = simulate(scene, strategy, seed)
            rows.append((episode.e_nodes, episode.e_targets, time.process_time() - began))
    return np.array(rows)


def setting(part: str) -> tuple[str, float | int | bool | str]:
    """A setting and its value, a number if it is one.

    >>> setting("rounds=2"), setting("streets=False"), setting("start=chosen")
    (('rounds', 2), ('streets', False), ('start', 'chosen'))
    """
    key, value = part.split("=")
    if value in ("True", "False"):
        return key, value == "True"
    for kind in (int, float):
        try:
            return key, kind(value)
        except ValueError:
            continue
    return key, value


def write(path: Path, flown: dict[str, np.ndarray]) -> None:
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["strategy", "e_nodes", "e_targets", "seconds"])
        for text, halves in flown.items():
            rows.writerows([text, *(f"{value:.6f}" for value in row)] for row in halves)


def read(path: Path) -> dict[str, np.ndarray]:
    flown: dict[str, list[list[float]]] = {}
    with path.open(newline="") as file:
        for text, *values in list(csv.reader(file))[1:]:
            flown.setdefault(text, []).append([float(value) for value in values])
    return {text: np.array(rows) for text, rows in flown.items()}


def show(flown: dict[str, np.ndarray]) -> None:
    """A table: means with standard errors, and the first one's lead over each, trial by trial."""
    print("| strategy | n | E | E_nodes | E_targ | lead of the first | CPU ms a trial |\n|---|---|---|---|---|---|---|")
    first = next(iter(flown.values()))[:, :2].sum(axis=1)
    for text, halves in flown.items():
        both = halves[:, :2].sum(axis=1)
        lead = told(first - both) if len(both) == len(first) and both is not first else ""
        print(f"| {text} | {len(both)} | {told(both)} | {told(halves[:, 0])} | {told(halves[:, 1])} | {lead} "
              f"| {1e3 * np.median(halves[:, 2]):.0f} |")  # fmt: skip


def told(values: np.ndarray) -> str:
    return f"{values.mean():.4f} +- {values.std(ddof=1) / len(values) ** 0.5:.4f}"


if __name__ == "__main__":
    main()
