"""Greedy over regions: the open action that pays most a second."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from sooner.problem import Incumbent, Plan, SearchProblem, evaluate
from sooner.problem.region_ground import RegionGround, single_region_searcher

__all__ = ["RegionGreedy"]


@dataclass(frozen=True)
class RegionGreedy:
    """Of the actions open here that leave time to get to the end, the best by rate; ties by what it pays in all.

    Until none fits. The baseline of Kuhlman et al. (2017), section 4.1.
    """

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher over regions."""
        return single_region_searcher(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Iterator[Incumbent]:
        """Yield once."""
        from sooner.planners._region_kernels import greedy

        ground = RegionGround.of(problem)
        starts, atoms, _, _, way_starts, ways, ends = ground.arrays
        looks = np.zeros(len(ground.gains), np.int64)
        actions = np.empty(int(ground.limit_s / ground.seconds.min()) + 1, np.int64)
        count = greedy(
            starts, atoms, ground.before, way_starts, ways, ends, ground.seconds, ground.gains, looks,
            ground.first, ground.limit_s, ground.to_last, actions,
        )  # fmt: skip
        flown = actions[:count].tolist()
        plan = Plan.of([*flown, *ground.homeward(ground.walked(flown))])
        yield Incumbent(plan, evaluate(problem, plan).value)
