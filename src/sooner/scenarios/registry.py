"""Every scenario by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from sooner.scenarios.bimodal import bimodal
from sooner.scenarios.lost_hiker import LostHiker, lost_hiker
from sooner.scenarios.many_hills import many_hills
from sooner.scenarios.rough_ground import RoughGround, rough_ground
from sooner.scenarios.rugged_ridge import rugged_ridge
from sooner.scenarios.scenario import Scenario
from sooner.scenarios.street_search import StreetSearch, street_search

__all__ = [
    "AREA_SCENARIOS",
    "SCENARIOS",
    "STREET_SCENARIOS",
    "make_area_scenario",
    "make_scenario",
    "make_street_scenario",
]


@dataclass(frozen=True)
class Entry:
    """One scenario: how it is made, and what it is about."""

    make: Callable[..., Scenario | RoughGround]
    about: str


@dataclass(frozen=True)
class StreetEntry:
    """One that is simulated and not planned ahead."""

    make: Callable[..., StreetSearch]
    about: str


@dataclass(frozen=True)
class AreaEntry:
    """One that is drawn on the globe and planned as a mission."""

    make: Callable[..., LostHiker]
    about: str


SCENARIOS: dict[str, Entry] = {
    "many-hills": Entry(many_hills, "40 hills of all sizes, half an hour of flight, and home again (100 x 100 cells)"),
    "rugged-ridge": Entry(rugged_ridge, "a ridge, forest that hides, rocks in the way (100 x 100 cells)"),
    "bimodal": Entry(bimodal, "a broad hill and a sharp one (60 x 60 cells)"),
    "rough-ground": Entry(
        rough_ground, "regions between obstacles, searched for what there is to learn (100 x 200 cells)"
    ),
}

"""Searches that can be planned ahead."""

AREA_SCENARIOS: dict[str, AreaEntry] = {
    "lost-hiker": AreaEntry(
        lost_hiker, "a command post's layers on the globe, two drones, four batteries, straight legs (about 4 km2)"
    ),
}
"""Searches over an area that is drawn; a mission reads them."""

STREET_SCENARIOS: dict[str, StreetEntry] = {
    "street-grid": StreetEntry(
        street_search, "four drones map unknown streets and hunt who walks there: for `sooner simulate` (40 x 40 cells)"
    ),
}
"""Searches that are planned while they are flown."""


def make_area_scenario(name: str, seed: int | None = None) -> LostHiker:
    """The search of that name over an area that is drawn; another seed makes another area.

    >>> sorted(make_area_scenario("lost-hiker").files())[:3]
    ['area.geojson', 'copter.toml', 'elevation.tif']
    """
    make = AREA_SCENARIOS[name].make
    return make() if seed is None else make(seed)


def make_street_scenario(name: str, seed: int | None = None) -> StreetSearch:
    """The search over streets of that name; another seed makes other streets.

    >>> make_street_scenario("street-grid").searchers
    4
    """
    make = STREET_SCENARIOS[name].make
    return make() if seed is None else make(seed)


def make_scenario(name: str, seed: int | None = None) -> Scenario | RoughGround:
    """The scenario of that name; another seed makes another search of its kind.

    >>> make_scenario("bimodal").start
    (30, 15)
    """
    make = SCENARIOS[name].make
    return make() if seed is None else make(seed)
