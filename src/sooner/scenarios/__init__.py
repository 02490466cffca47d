"""Ready-made searches, made by seeded generators of our own: nothing needs to be downloaded."""

from sooner.scenarios.bimodal import bimodal
from sooner.scenarios.drifting_hiker import drifting_hiker
from sooner.scenarios.lost_hiker import LostHiker, lost_hiker
from sooner.scenarios.many_hills import many_hills
from sooner.scenarios.natural import (
    EXPERIMENT_2_CELLS,
    NATURAL_KINDS,
    NaturalEnvironment,
    downsampled,
    experiment_2,
    natural_environment,
    natural_environments,
    starts,
)
from sooner.scenarios.registry import (
    AREA_SCENARIOS,
    SCENARIOS,
    STREET_SCENARIOS,
    make_area_scenario,
    make_scenario,
    make_street_scenario,
)
from sooner.scenarios.rough_ground import RoughGround, rough_ground
from sooner.scenarios.rugged_ridge import rugged_ridge
from sooner.scenarios.scenario import Scenario
from sooner.scenarios.simplex_noise import elevation, simplex_noise
from sooner.scenarios.street_grid import STREET_KINDS, street_grid
from sooner.scenarios.street_search import StreetSearch, street_search

__all__ = [
    "AREA_SCENARIOS",
    "EXPERIMENT_2_CELLS",
    "NATURAL_KINDS",
    "SCENARIOS",
    "STREET_KINDS",
    "STREET_SCENARIOS",
    "LostHiker",
    "NaturalEnvironment",
    "RoughGround",
    "Scenario",
    "StreetSearch",
    "bimodal",
    "downsampled",
    "drifting_hiker",
    "elevation",
    "experiment_2",
    "lost_hiker",
    "make_area_scenario",
    "make_scenario",
    "make_street_scenario",
    "many_hills",
    "natural_environment",
    "natural_environments",
    "rough_ground",
    "rugged_ridge",
    "simplex_noise",
    "starts",
    "street_grid",
    "street_search",
]
