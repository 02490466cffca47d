"""Maps of a judged plan: where the person may be before and after it, and how surely it would have found them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.belief import Belief, BetaGrid
from sooner.errors import UnsupportedProblemError
from sooner.missions.mission_file import Mission
from sooner.missions.score import Score
from sooner.problem import detection_gains
from sooner.problem.leg_moves import LegMoves
from sooner.sensors.swath import pod

__all__ = ["LAYERS", "chances", "pod_by_cell"]

LAYERS = {
    "poc-before": "probability that the person is there, before the flight",
    "poc-after": "probability that the person is there and the flight has not found them: what remains",
    "pod": "probability that the flight detects who is there",
}


def chances(score: Score) -> dict[str, NDArray[np.float64]]:
    """The layers of `LAYERS`, (H, W) float each, by the judge's own gains.

    POD_i = 1 - P(all looks at i miss | there),   after_i = POC_i (1 - POD_i);   along legs POD_i = 1 - exp(-effort_i)

    What remains does not total one: what is missing was found, or lies outside. Over evidence POC is the probability of
    each cell by itself.

    Raises
    ------
    UnsupportedProblemError     where targets come and go, and nobody is found
    """
    sight = score.mission.sight
    if isinstance(sight.known, BetaGrid):
        raise UnsupportedProblemError('model = "beta" came, where nobody is found; geotiff expects looks that detect')
    before = sight.theta
    detected = pod_by_cell(score.mission, score.looks).reshape(before.shape)
    return {"poc-before": before, "poc-after": before * (1.0 - detected), "pod": detected}


def pod_by_cell(mission: Mission, looks: NDArray[Any]) -> NDArray[np.float64]:
    """(N,) float: P(so many looks detect who is there), by the judge's own gains; along legs 1 - exp(-effort)."""
    if isinstance(mission.problem.searchers[0].moves, LegMoves):
        return pod(looks)
    found, seen = np.zeros(looks.shape), np.flatnonzero(looks)
    if len(seen):
        alike = Belief.from_weights(np.ones((1, len(seen))))
        gains = detection_gains(alike, np.ravel(mission.glimpse)[None, seen], mission.sight.correlation)
        found[seen] = np.minimum(gains.total(np.arange(len(seen)), looks[seen].astype(np.float64)) * len(seen), 1.0)
    return found
