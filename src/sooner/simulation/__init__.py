"""What happens if it is flown: agents, looks, beliefs and replanning in one loop, and the episode that it leaves."""

from sooner.simulation.agents import Agent, Team, flight
from sooner.simulation.episode import Beliefs, Call, Episode, Looks
from sooner.simulation.episode_file import replayed
from sooner.simulation.episodes import load_episode, save_episode
from sooner.simulation.estimation import Estimator
from sooner.simulation.links import Links
from sooner.simulation.loop import Keep, simulate
from sooner.simulation.plan_episode import PlanEpisode
from sooner.simulation.scene import Scene
from sooner.simulation.sensing import HALF_CELL, Sensing
from sooner.simulation.world import World

__all__ = [
    "HALF_CELL",
    "Agent",
    "Beliefs",
    "Call",
    "Episode",
    "Estimator",
    "Keep",
    "Links",
    "Looks",
    "PlanEpisode",
    "Scene",
    "Sensing",
    "Team",
    "World",
    "flight",
    "load_episode",
    "replayed",
    "save_episode",
    "simulate",
]
