"""Proven bounds: values that no plan can pass."""

from __future__ import annotations

from sooner.bounds.bound import Bound
from sooner.bounds.connected_subgraph import ConnectedSubgraph
from sooner.bounds.proofs import bounds
from sooner.bounds.region_lp import RegionLP
from sooner.bounds.soonest import soonest_bounds

__all__ = ["Bound", "ConnectedSubgraph", "RegionLP", "bounds", "soonest_bounds"]
