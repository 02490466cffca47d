"""Planners on SAREnv's scenarios, by its measure and by what they truly sweep.

    python benchmarks/sarenv/study.py --data $SOONER_DATA/sarenv [--only router cells legs] [--seeds 3] [--seconds 10]
    python benchmarks/sarenv/study.py --data $SOONER_DATA/sarenv --table

Goes on where sarenv.csv stops. Every way of ours begins and ends in the centre, its return within the budget; SAREnv's
own patterns stop where the budget does.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np
from cells import walk
from legs import fly as fly_legs
from numpy.typing import NDArray
from patterns import PATTERNS
from router import route

from sooner.experiments.sarenv import Sarenv, load_sarenv, scores, swept_bound

Ways = list[NDArray[np.float64]]

SCENARIOS = ("sarenv_02", "sarenv_12")
TEAMS = ((1, 20_000.0), (3, 60_000.0), (5, 300_000.0))
MEASURES = ("likelihood", "swept", "time_discounted", "victims_percent", "area_km2", "length_km")
FIELDS = ("scenario", "drones", "metres", "planner", "pitch_m", "seconds", "seed", *MEASURES, "cpu_s")
FILE = Path(__file__).parent / "sarenv.csv"

MANUALS = ("parallel-track", "creeping-line", "expanding-square", "sector", "no-gap")
MANUAL_ROWS = 7  # of cells across the swath, by which their variants are judged

Key = tuple[str, ...]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="folder of sarenv_02.json and the others")
    parser.add_argument("--only", nargs="*", default=["patterns", *PLANNERS], help=" ".join(["patterns", *PLANNERS]))
    parser.add_argument("--pitches", nargs="*", default=["true", "90"], help="metres, or true for twice the radius")
    parser.add_argument("--rows", type=int, nargs="*", default=[0, 7], help="of cells across the swath, for legs")
    parser.add_argument("--drones", type=int, nargs="*", default=[1, 3, 5])
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--table", action="store_true")
    given = parser.parse_args()
    scenarios = [load_sarenv(given.data, name) for name in SCENARIOS]
    if given.table:
        print(tables(scenarios))
        return
    teams = [team for team in TEAMS if team[0] in given.drones]
    for scenario in scenarios:
        for drones, metres in teams:
            for row in rows(scenario, drones, metres, given):
                _add(row)


def rows(scenario: Sarenv, drones: int, metres: float, given: argparse.Namespace) -> Iterator[dict[str, object]]:
    """What is asked for and not in the file."""
    for name, pattern in PATTERNS.items() if "patterns" in given.only else ():
        for seed in range(given.seeds if name == "Greedy" else 1):
            more = {"seed": seed} if name == "Greedy" else {}
            fly = lambda pattern=pattern, more=more: pattern(scenario, drones, metres, **more)  # noqa: E731
            yield from _row(scenario, drones, metres, name, ("", "", str(seed)), fly)
    for name, planner in PLANNERS.items():
        for cut, told in _cuts(scenario, name, given) if name in given.only else ():
            for seed in range(1 if name in MANUALS else given.seeds):
                fly = lambda planner=planner, cut=cut, seed=seed: planner(  # noqa: E731
                    scenario, drones, metres, cut, given.seconds, seed
                )
                how = (told, f"{given.seconds:g}", str(seed))
                yield from _row(scenario, drones, metres, name, how, fly)


PLANNERS: dict[str, Callable[..., Ways]] = {
    "router": route,
    "cells": walk,
    "legs": fly_legs,
    "legs-edged": partial(fly_legs, law="edged"),
    **{name: partial(fly_legs, pattern=name) for name in MANUALS},
}


def _cuts(scenario: Sarenv, name: str, given: argparse.Namespace) -> Iterator[tuple[float, str]]:
    """What a planner sees of the ground, and the metres between its nodes or cells."""
    across = 2 * scenario.radius_m
    if name in MANUALS:
        yield MANUAL_ROWS, f"{across / MANUAL_ROWS:.2f}"
        return
    if name.startswith("legs"):
        for rows in given.rows:
            yield rows, f"{across / rows if rows else scenario.cell_m:.2f}"
        return
    for pitch in given.pitches:
        pitch_m = across if pitch == "true" else float(pitch)
        yield pitch_m, f"{pitch_m:.2f}"


def _row(
    scenario: Sarenv, drones: int, metres: float, name: str, how: tuple[str, str, str], fly: Callable[[], Ways]
) -> Iterator[dict[str, object]]:
    key = (scenario.name, str(drones), f"{metres:g}", name, *how)
    if key in {_key(row) for row in _read()}:
        return
    began = time.process_time()
    ways = fly()
    cpu_s = time.process_time() - began
    yield dict(zip(FIELDS, key, strict=False)) | asdict(scores(scenario, ways)) | {"cpu_s": round(cpu_s, 2)}


def _key(row: dict[str, str]) -> Key:
    return tuple(row[field] for field in FIELDS[:7])


def _read() -> list[dict[str, str]]:
    if not FILE.exists():
        return []
    with FILE.open(newline="") as file:
        return list(csv.DictReader(file))


def _add(row: dict[str, object]) -> None:
    new = not FILE.exists()
    with FILE.open("a", newline="") as file:
        writer = csv.DictWriter(file, FIELDS)
        if new:
            writer.writeheader()
        writer.writerow({field: _short(row[field]) for field in FIELDS})
    print(" ".join(str(_short(row[field])) for field in FIELDS), flush=True)


def _short(value: object) -> object:
    return f"{value:.6g}" if isinstance(value, float) else value


def tables(scenarios: list[Sarenv]) -> str:
    """One table for each scenario and team: medians over seeds, the best in brackets."""
    return "\n\n".join(_table(scenario, *team) for scenario in scenarios for team in TEAMS)


def _table(scenario: Sarenv, drones: int, metres: float) -> str:
    total, bound = float(scenario.heat.sum()), swept_bound(scenario, metres)
    lines = [
        f"### {scenario.name}, {drones} drone{'s' * (drones > 1)}, {metres / 1000:g} km in all",
        "",
        f"All heat {total:.4f}; no ways of this length from one place sweep more than {bound:.4f}.",
        "",
        "| planner | pitch, m | s | n | SAREnv's score | truly swept | % of bound | discounted | victims, % | km2 |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for told in scenario.baselines:
        if (told["n_drones"], told["budget_m"]) == (drones, metres):
            kept = [f"{told['likelihood']:.4f}", "", "", f"{told['time_discounted']:.4f}"]
            kept += [f"{told['victims_pct']:.0f}", f"{told['area_km2']:.3f}"]
            lines.append(f"| {told['algorithm']}, as published | | | 1 | {' | '.join(kept)} |")
    groups: dict[Key, list[dict[str, str]]] = {}
    for row in _read():
        if _key(row)[:3] == (scenario.name, str(drones), f"{metres:g}"):
            groups.setdefault(_key(row)[3:6], []).append(row)
    for (name, pitch, seconds), found in groups.items():
        by = {measure: [float(row[measure]) for row in found] for measure in MEASURES}
        cells = [name, pitch, seconds, str(len(found)), _of(by["likelihood"]), _of(by["swept"])]
        cells += [f"{100 * median(by['swept']) / bound:.1f}", f"{median(by['time_discounted']):.4f}"]
        cells += [f"{median(by['victims_percent']):.0f}", f"{median(by['area_km2']):.3f}"]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _of(values: list[float]) -> str:
    return f"{median(values):.4f} ({max(values):.4f})" if len(values) > 1 else f"{values[0]:.4f}"


if __name__ == "__main__":
    main()
