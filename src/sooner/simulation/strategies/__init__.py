"""Ways to fly a search: what is known in, routes of waypoints out."""

from sooner.simulation.strategies.lawnmower import TUNED_LAWNMOWER, Lawnmower
from sooner.simulation.strategies.random_waypoints import RandomWaypoints
from sooner.simulation.strategies.strategy import Routes, Session, Situation, Strategy

__all__ = ["TUNED_LAWNMOWER", "Lawnmower", "RandomWaypoints", "Routes", "Session", "Situation", "Strategy"]
