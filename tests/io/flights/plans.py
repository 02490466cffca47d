"""Flights for tests: one that is right, any that hypothesis can think of, and names that mean harm."""

from dataclasses import replace

from hypothesis import strategies as st

from sooner.io.flights import Fence, FlightPlan, Waypoint

HOSTILE = [
    "<script>alert(1)</script>",
    "a & b \"quoted\" 'single' ]]> <!-- -->",
    "two\nlines\r\tand a tab",
    "&lt;name&gt; &#10; %s {0} \\u0041",
    "Zürich 雪 \U0001f681",
    "x" * 10_000,
    "",
]
UNSAYABLE = "bell \x07, nul \x00, lone \ud800, last \uffff"

RIDGE = FlightPlan(
    "ridge",
    0,
    (46.0, 11.0),
    (
        Waypoint(46.0, 11.0, 60.0),
        Waypoint(46.001234567, 11.0, 60.0, hold_s=4.0),
        Waypoint(46.001234567, 11.002, 75.5, speed_mps=6.0),
        Waypoint(46.0, 11.0, 60.0),
    ),
    speed_mps=12.0,
    duration_s=61.5,
    fences=(
        Fence(((45.9, 10.9), (45.9, 11.1), (46.1, 11.1), (46.1, 10.9)), True),
        Fence(((46.0005, 11.0005), (46.0005, 11.001), (46.0007, 11.001)), False),
    ),
    landings=((46.002, 11.001),),
)


def named(name: str) -> FlightPlan:
    return replace(RIDGE, name=name)


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_infinity=False)


@st.composite
def flight_plans(draw, fewest: int = 1, copters: bool = False) -> FlightPlan:
    """Any flight, anywhere that is not near a pole, on one side of the date line."""
    south, west = draw(numbers(-89.0, 88.0)), draw(numbers(-180.0, 179.0))
    place = st.tuples(numbers(south, south + 0.9), numbers(west, west + 0.9))
    speeds = st.none() | numbers(0.5, 40.0)
    waypoint = st.builds(
        lambda at, up, speed, hold: Waypoint(*at, up, speed, hold),
        place,
        numbers(1.0, 1_500.0),
        speeds,
        numbers(0.0, 600.0),
    )
    fence = st.builds(
        lambda corners, inclusion: Fence(tuple(corners), inclusion),
        st.lists(place, min_size=3, max_size=6),
        st.booleans(),
    )
    return FlightPlan(
        draw(st.text(st.characters(codec="utf-8"), max_size=20)),
        draw(st.integers(0, 9)),
        draw(place),
        tuple(draw(st.lists(waypoint, min_size=fewest, max_size=8))),
        draw(st.sampled_from(["return", "land", "loiter"])),
        draw(numbers(0.5, 40.0) if copters else speeds),
        draw(st.none() | numbers(0.0, 1e5)),
        fences=tuple(draw(st.lists(fence, max_size=3))),
        landings=tuple(draw(st.lists(place, max_size=2))),
        kind="copter" if copters else draw(st.sampled_from(["copter", "fixed_wing"])),
    )
