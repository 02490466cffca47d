"""The iterative greedy reference of a search over regions, for one searcher or several."""

from __future__ import annotations

from math import nan

import numpy as np

from sooner.bounds.region_lp import picked_by_rate
from sooner.bounds.region_network import RegionNetwork
from sooner.planners.depth_first import relaxation
from sooner.problem import SearchProblem
from sooner.problem.region_ground import RegionGround

__all__ = ["iterative_greedy"]


def iterative_greedy(problem: SearchProblem) -> float:
    """What actions picked by rate from anywhere collect in the time of all searchers [Kuhlman2017, eq. (4)].

    A reference and no bound: where footprints overlap plans have passed it. NaN where the person moves.
    """
    if problem.drift is not None:
        return nan
    if len(problem.searchers) == 1:
        return relaxation(RegionGround.of(problem))[0]
    network = RegionNetwork.of(problem)
    gains = network.ground.gains
    looks = np.minimum(network.looks(picked_by_rate(network)).astype(np.int64), gains.shape[1])
    sums = np.concatenate([np.zeros((len(gains), 1)), np.cumsum(gains, axis=1)], axis=1)
    return float(network.ground.leg_value + sums[np.arange(len(gains)), looks].sum())
