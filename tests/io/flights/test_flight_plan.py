"""A flight that cannot be flown is not made."""

from dataclasses import replace
from math import inf, nan

import pytest

from sooner.errors import DataFormatError, InvalidProblemError
from sooner.io.flights import AUTOPILOTS, DJI_MODELS, Aircraft, Fence, FlightPlan, Waypoint
from sooner.io.flights import mission_items as mission_items_module
from sooner.io.flights.mission_items import mission_items
from tests.io.flights.plans import RIDGE


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"lat": nan}, "latitude of nan"),
        ({"lat": 90.0}, "expected -89.9 to 89.9 degrees"),
        ({"lon": 180.5}, "longitude of 180.5"),
        ({"lon": -inf}, "longitude of -inf"),
        ({"altitude_m": -10_001.0}, "altitude of -10001.0"),
        ({"altitude_m": nan}, "altitude of nan"),
        ({"speed_mps": 0.0}, "speed of 0.0"),
        ({"hold_s": -1.0}, "hold of -1.0"),
        ({"hold_s": inf}, "hold of inf"),
    ],
)
def test_a_waypoint_that_is_none_is_refused(wrong, told):
    with pytest.raises(InvalidProblemError, match=told):
        Waypoint(**({"lat": 46.0, "lon": 11.0, "altitude_m": 60.0} | wrong))


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"waypoints": ()}, "without waypoints"),
        ({"home": (nan, 11.0)}, "latitude of nan"),
        ({"speed_mps": -2.0}, "speed of -2.0"),
        ({"duration_s": nan}, "duration of nan"),
        ({"home_altitude_m": inf}, "altitude of home"),
        ({"landings": ((0.0, 200.0),)}, "longitude of 200.0"),
        ({"home": (46.0, -179.0)}, "one side of the date line"),
    ],
)
def test_a_flight_that_is_none_is_refused(wrong, told):
    with pytest.raises(InvalidProblemError, match=told):
        replace(RIDGE, **wrong)


def test_a_flight_over_the_date_line_is_refused():
    east, west = Waypoint(-17.0, 179.99, 60.0), Waypoint(-17.0, -179.99, 60.0)
    with pytest.raises(InvalidProblemError, match="date line"):
        FlightPlan("Taveuni", 0, (-17.0, 179.98), (east, west))


def test_a_fence_needs_three_corners_on_one_side():
    with pytest.raises(InvalidProblemError, match="2 corners"):
        Fence(((46.0, 11.0), (46.1, 11.0)), True)
    with pytest.raises(InvalidProblemError, match="date line"):
        Fence(((0.0, 179.0), (1.0, -179.0), (1.0, 179.0)), True)


def test_a_waypoint_without_a_speed_has_the_flights():
    assert [*RIDGE.speeds] == [12.0, 12.0, 6.0, 12.0]


def test_speeds_are_told_where_they_change():
    speeds = [item.settings[1] for item in mission_items(RIDGE) if item.command == 178]
    assert speeds == [12.0, 6.0, 12.0]
    assert not [item for item in mission_items(replace(RIDGE, speed_mps=None)) if item.command == 178][1:]


@pytest.mark.parametrize(("finish", "command"), [("return", 20), ("land", 21), ("loiter", 17)])
def test_a_flight_ends_as_it_says(finish, command):
    assert mission_items(replace(RIDGE, finish=finish))[-1].command == command


def test_who_lands_away_lands_below_its_last_waypoint():
    landed = mission_items(replace(RIDGE, finish="land"))[-1]
    assert (landed.lat, landed.lon, landed.altitude_m) == (*RIDGE.places[-1], 0.0)


def test_more_items_than_mavlink_counts_are_refused(monkeypatch):
    assert mission_items_module.MOST_ITEMS == 2**16 - 1
    monkeypatch.setattr(mission_items_module, "MOST_ITEMS", 9)
    with pytest.raises(InvalidProblemError, match="MAVLink counts to"):
        mission_items(RIDGE)


def test_an_aircraft_that_nobody_knows_is_refused():
    for wrong in ({"autopilot": "arducopter"}, {"dji": "phantom"}):
        with pytest.raises(DataFormatError, match="expected one of"):
            Aircraft(**wrong)
    assert Aircraft("px4").firmware == AUTOPILOTS["px4"] == 12
    assert {(model.drone, model.sub) for model in DJI_MODELS.values()} == {
        (60, 0), (89, 0), (67, 0), (67, 1), (77, 0), (77, 1), (91, 0), (91, 1),
    }  # fmt: skip
