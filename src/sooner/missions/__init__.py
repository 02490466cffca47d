"""The user's work from end to end: a mission file becomes a problem, a plan and a report."""

from sooner.missions.mission_file import Mission, read_mission
from sooner.missions.planning import Planned, plan_mission, read_plan_file
from sooner.missions.score import Score, score_plan
from sooner.missions.settings import Settings

__all__ = ["Mission", "Planned", "Score", "Settings", "plan_mission", "read_mission", "read_plan_file", "score_plan"]
