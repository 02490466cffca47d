"""A bound beside a plan that lies in a file: what no plan can pass, as far as it is proved in the time given."""

from __future__ import annotations

import time
from math import inf

from sooner.bounds.bound import Bound
from sooner.bounds.proofs import bounds
from sooner.missions.score import Score

__all__ = ["tightest"]


def tightest(score: Score, seconds: float) -> Bound | None:
    """The tightest bound that is proved within so many seconds, the first in any case; None where nothing is proved.

    For a target the bound is minus the time before which no plan reaches it; one that says nothing is none.
    """
    begun, best = time.monotonic(), None
    for found in bounds(score.mission.problem, score.evaluation.value):
        if best is None or found.value < best.value:
            best = found
        if found.value <= score.evaluation.value or time.monotonic() - begun >= seconds:
            break
    target = score.mission.problem.objective.target
    says = best is not None and (best.value < (inf if target is None else 0.0))
    return best if says else None
