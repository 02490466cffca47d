"""Maps of a judged plan: where the person may be before and after it, and how surely it would have found them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sooner.belief import Belief, BetaGrid
from sooner.errors import UnsupportedProblemError
from sooner.missions.score import Score
from sooner.problem import Gains, detection_gains
from sooner.sensors.swath import pod as pod_of_effort

__all__ = ["LAYERS", "chances"]

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
    before, seen = sight.theta, np.flatnonzero(score.looks)
    pod = np.zeros(before.shape)
    if score.mission.over_legs:
        pod = pod_of_effort(score.looks).reshape(before.shape)
    elif len(seen):
        alike = Belief.from_weights(np.ones((1, len(seen))))
        gains = detection_gains(alike, np.ravel(sight.glimpse)[None, seen], sight.correlation)
        pod.flat[seen] = np.minimum(_paid(gains, score.looks[seen]) * len(seen), 1.0)
    return {"poc-before": before, "poc-after": before * (1.0 - pod), "pod": pod}


def _paid(gains: Gains, looks: NDArray[np.int64]) -> NDArray[np.float64]:
    """(N,) float: what so many looks at each cell pay in all: the table's, then the geometric tail."""
    columns = gains.table.shape[1]
    in_table = np.concatenate([np.zeros((len(looks), 1)), np.cumsum(gains.table, axis=1)], axis=1)
    paid = in_table[np.arange(len(looks)), np.minimum(looks, columns)]
    ratio, more = gains.ratio, np.maximum(looks - columns, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        terms = np.where(ratio < 1.0, ratio * (1.0 - ratio**more) / (1.0 - ratio), more)
    return np.asarray(paid + gains.table[:, -1] * terms)
