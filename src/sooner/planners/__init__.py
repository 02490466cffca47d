"""How to choose where to look: `solve`, its stop rules, and one file per planner."""

from sooner.planners.global_warming import GlobalWarming
from sooner.planners.greedy import Greedy
from sooner.planners.mode_goodness import ModeGoodness
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
from sooner.planners.top2 import Top2
from sooner.planners.topn import TopN

__all__ = [
    "GlobalWarming",
    "Greedy",
    "ModeGoodness",
    "Planner",
    "Progress",
    "Solution",
    "Status",
    "StopRule",
    "Ticks",
    "Top2",
    "TopN",
    "gap_below",
    "max_seconds",
    "max_ticks",
    "never",
    "solve",
    "value_reached",
]
