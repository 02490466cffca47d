"""How early plans pay: as planned, and brought forward at the cost of 0.5 % of the total.

python benchmarks/regions/early.py --environments 1-5 --seconds 2
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace

import numpy as np
from study import KINDS, PRESET_A, PRIORS, aware, plain

from sooner.belief import EvidenceGrid
from sooner.decomposition import boustrophedon
from sooner.experiments.flight import cpu_seconds
from sooner.planners import solve
from sooner.planners.depth_first import relaxation
from sooner.planners.region_anneal import RegionAnneal
from sooner.planners.region_early import brought_forward
from sooner.problem import Plan, SearchProblem, evaluate
from sooner.problem.information_gains import information_gains
from sooner.problem.region_ground import RegionGround
from sooner.problem.region_problem import region_problem, two_searches_s
from sooner.scenarios.natural import natural_environment, starts
from sooner.sensors import BinarySensor

STEPS = 40


def posed(kind: str, prior: str, number: int, cut: object) -> SearchProblem:
    """The mission time is that of the plain decomposition."""
    ground = natural_environment(kind, number, nonuniform=prior == "nonuniform")
    gains = information_gains(EvidenceGrid(ground.theta), BinarySensor(0.85, 0.15))
    base, places = boustrophedon(ground.grid), starts(ground, 1, 1)
    budget_s = two_searches_s(region_problem(ground.grid, base, PRESET_A, gains, places, 1e9))
    sweep = replace(PRESET_A, looks="passes")
    return region_problem(ground.grid, cut(ground.grid, base, gains.first), sweep, gains, places, budget_s)


def teleporting(problem: SearchProblem, total: float) -> float:
    """Early share of a searcher that is anywhere at once, for each length of mission anew: about the most there is."""
    ground = RegionGround.of(problem)
    shares = (np.arange(STEPS) + 0.5) / STEPS
    return float(np.mean([relaxation(replace(ground, limit_s=ground.limit_s * s))[0] for s in shares])) / total


def measured(problem: SearchProblem, seconds: float) -> tuple[float, ...]:
    plan = solve(problem, RegionAnneal(), cpu_seconds(seconds)).best.plan
    began = time.process_time()
    early = brought_forward(problem, Plan.of(plan.actions[0]))
    took = time.process_time() - began
    as_planned, after = evaluate(problem, plan), evaluate(problem, early)
    most = teleporting(problem, 0.995 * as_planned.total)
    return as_planned.early_share, after.early_share, most, 100.0 * after.total / as_planned.total, took


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--environments", default="1-5", help="first-last")
    parser.add_argument("--seconds", type=float, default=2.0, help="of processor time for each plan")
    given = parser.parse_args()
    first, last = map(int, given.environments.split("-"))
    print("| class | prior | cut | n | as planned | brought forward | teleporting | total kept, % | seconds |")
    print("|---|---|---|---|---|---|---|---|---|")
    for prior in PRIORS:
        for kind in KINDS:
            for cut in (plain, aware) if prior == "nonuniform" else (plain,):
                rows = [measured(posed(kind, prior, n, cut), given.seconds) for n in range(first, last + 1)]
                early, later, most, kept, took = np.mean(rows, axis=0)
                numbers = f"{early:.3f} | {later:.3f} | {most:.3f} | {kept:.2f} | {took:.1f}"
                print(f"| {kind} | {prior} | {cut.__name__} | {len(rows)} | {numbers} |", flush=True)


if __name__ == "__main__":
    main()
