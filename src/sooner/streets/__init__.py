"""Streets: where a target that keeps to them may be, its states with a heading, and how it walks."""

from sooner.streets.occupancy import OccupancyGraph
from sooner.streets.rasterise import rasterised
from sooner.streets.target_states import Growth, TargetStates, growth
from sooner.streets.walk import Bias, Evasive, TargetWalk, turn_weights

__all__ = [
    "Bias",
    "Evasive",
    "Growth",
    "OccupancyGraph",
    "TargetStates",
    "TargetWalk",
    "growth",
    "rasterised",
    "turn_weights",
]
