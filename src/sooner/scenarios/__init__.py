"""Ready-made searches, made by seeded generators of our own: nothing needs to be downloaded."""

from sooner.scenarios.bimodal import bimodal
from sooner.scenarios.drifting_hiker import drifting_hiker
from sooner.scenarios.many_hills import many_hills
from sooner.scenarios.registry import SCENARIOS, make_scenario
from sooner.scenarios.rugged_ridge import rugged_ridge
from sooner.scenarios.scenario import Scenario

__all__ = ["SCENARIOS", "Scenario", "bimodal", "drifting_hiker", "make_scenario", "many_hills", "rugged_ridge"]
