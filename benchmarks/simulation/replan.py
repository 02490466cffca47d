"""What it is worth to plan anew on the way with what looks have answered, on a map and ground made here.

python benchmarks/simulation/replan.py --flights 100

One person with false alarms, targets, rates of targets that come and go, and teams over regions: each mission is
planned once, and flown by the same seeds to the end of that plan, and with a new plan every so often. Bits and targets
are those of the trials. A person is found or not, which tells little in a hundred flights: P(found | all answers) is
told, the chance that the person is where a look said yes, of which finding is a draw.
"""

from __future__ import annotations

import argparse
import tempfile
from math import inf
from pathlib import Path

import numpy as np

from sooner.io import raster_csv
from sooner.missions import Mission, plan_mission, read_mission
from sooner.missions.estimates import Mean
from sooner.missions.plan_trials import PlanTrial
from sooner.missions.replanned import Replanning
from sooner.simulation.answers import theta_of
from sooner.simulation.hidden import Hidden

SIDE = 30
CELLS = "[[searcher]]\nstart = [15, 15]\n[budget]\nsteps = 900\n"
DRONE = '[[searcher]]\nstart = [{row}, {col}]\nmoves = "regions"\nspeed_mps = 10.0\naccel_mps2 = 2.0\n'
TEAM = DRONE.format(row=1, col=1) + DRONE.format(row=28, col=28)
EVIDENCE = '[area]\nevidence = "map.csv"\ncell_m = 5.0\n[sensor]\n'
BITS = '[objective]\nkind = "information"\n'
# mission, seconds or steps between plans
CASES = {
    "person, f 0.02": ('[area]\npoc = "map.csv"\n[sensor]\ndetect = 0.5\nfalse_alarm = 0.02\n' + CELLS, 100),
    "person, f 0.1": ('[area]\npoc = "map.csv"\n[sensor]\ndetect = 0.5\nfalse_alarm = 0.1\n' + CELLS, 100),
    "person, f 0.3": ('[area]\npoc = "map.csv"\n[sensor]\ndetect = 0.5\nfalse_alarm = 0.3\n' + CELLS, 100),
    "targets": (EVIDENCE + "detect = 0.5\nfalse_alarm = 0.1\n" + CELLS, 100),
    "bits": (EVIDENCE + "detect = 0.8\nfalse_alarm = 0.2\n" + CELLS + BITS, 100),
    "rates, bits": (EVIDENCE + 'model = "beta"\n' + CELLS + BITS, 100),
    "two drones over regions, targets": (
        EVIDENCE + "detect = 0.5\nfalse_alarm = 0.1\nradius_m = 10.0\n" + TEAM + "[budget]\nseconds = 400\n",
        60,
    ),
    "two drones over regions, bits": (
        EVIDENCE + "detect = 0.8\nfalse_alarm = 0.2\nradius_m = 10.0\n" + TEAM + "[budget]\nseconds = 400\n" + BITS,
        60,
    ),
}


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--flights", type=int, default=100)
    asked.add_argument("--planner", default="greedy", help="over cells; over regions it is region-anneal")
    asked.add_argument("--first", type=int, default=1000, help="the first seed")
    asked.add_argument("--cases", default="", help="only those with this in their name")
    flags = asked.parse_args()
    print("| mission | planned once | planned anew | ahead by | standard errors | n |\n|---|---|---|---|---|---|")
    for name, (text, every) in CASES.items():
        if flags.cases in name:
            print(_row(name, text, every, flags), flush=True)


def _row(name: str, text: str, every: float, flags: argparse.Namespace) -> str:
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "map.csv").write_bytes(raster_csv(_map()))
        (Path(folder) / "mission.toml").write_text(text)
        mission = read_mission(Path(folder) / "mission.toml")
    planner = None if mission.over_regions else flags.planner
    planned = plan_mission(mission, planner, seconds=2.0, seed=1)
    seeds = range(flags.first, flags.first + flags.flights)
    once, anew = (
        [_value(Replanning(mission, planned.score.plan, planned.planner, time), seed) for seed in seeds]
        for time in (inf, every)
    )
    ahead = Mean.of(np.subtract(anew, once).tolist())
    assert ahead.value is not None
    assert ahead.error is not None
    told = " | ".join(Mean.of(values).told(4) for values in (once, anew))
    return f"| {name} | {told} | {ahead.told(4)} | {ahead.value / ahead.error:.1f} | {ahead.n} |"


def _value(flight: Replanning, seed: int) -> float:
    mission: Mission = flight.mission
    hidden = Hidden(mission.sight.answers, seed)
    for stretch in flight.stretches(hidden, seed):
        hidden.look(stretch.soon.cells, stretch.soon.times)
    if mission.sight.unit != "probability":
        return PlanTrial.told(seed, mission.sight, hidden).value
    return float(theta_of(hidden.model.after(hidden.looks, hidden.hits))[hidden.hits > 0].sum())


def _map() -> np.ndarray:
    """(H, W) float in (0, 1): three hills on a plain."""
    rows, cols = np.mgrid[:SIDE, :SIDE]
    hills = sum(
        height * np.exp(-((rows - row) ** 2 + (cols - col) ** 2) / (2.0 * width**2))
        for row, col, height, width in ((8, 8, 0.6, 3.0), (20, 14, 0.5, 4.0), (12, 23, 0.4, 3.0))
    )
    return np.asarray(0.05 + hills).round(4)


if __name__ == "__main__":
    main()
