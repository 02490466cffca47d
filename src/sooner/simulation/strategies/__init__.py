"""Ways to fly a search: what is known in, routes of waypoints out."""

from sooner.simulation.strategies.information import SWEPT_INFORMATION, Information
from sooner.simulation.strategies.joint import Joint
from sooner.simulation.strategies.lawnmower import TUNED_LAWNMOWER, Lawnmower
from sooner.simulation.strategies.random_waypoints import RandomWaypoints
from sooner.simulation.strategies.registry import STRATEGIES, make_strategy
from sooner.simulation.strategies.rollouts import Rollouts
from sooner.simulation.strategies.strategy import Routes, Session, Situation, Strategy

__all__ = [
    "STRATEGIES",
    "SWEPT_INFORMATION",
    "TUNED_LAWNMOWER",
    "Information",
    "Joint",
    "Lawnmower",
    "RandomWaypoints",
    "Rollouts",
    "Routes",
    "Session",
    "Situation",
    "Strategy",
    "make_strategy",
]
