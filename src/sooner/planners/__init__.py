"""How to choose where to look: `solve`, its stop rules, and one file per planner."""

from sooner.planners.greedy import Greedy
from sooner.planners.planner import Planner, Ticks
from sooner.planners.solve import Solution, Status, solve
from sooner.planners.stop import (
    Progress,
    StopRule,
    gap_below,
    max_seconds,
    max_ticks,
    never,
    value_reached,
)

__all__ = [
    "Greedy",
    "Planner",
    "Progress",
    "Solution",
    "Status",
    "StopRule",
    "Ticks",
    "gap_below",
    "max_seconds",
    "max_ticks",
    "never",
    "solve",
    "value_reached",
]
