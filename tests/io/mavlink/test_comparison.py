"""What counts as a difference."""

import struct
from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st

from sooner.io.flights.mission_items import MissionItem
from sooner.io.mavlink.comparison import differences
from sooner.io.mavlink.items import FENCE, MISSION, RALLY, items_of
from tests.io.flights.plans import flight_plans


def stored(item):
    """As a vehicle stores it: positions in units of 1e-7 degrees, the rest in floats of 32 bits."""
    settings = tuple(None if each is None else single(each) for each in item.settings)
    lat, lon = round(item.lat * 1e7) / 1e7, round(item.lon * 1e7) / 1e7
    return MissionItem(item.command, item.frame, settings, lat, lon, single(item.altitude_m))


def single(value):
    return struct.unpack("f", struct.pack("f", value))[0]


@given(plan=flight_plans(), ardupilot=st.booleans())
def test_what_is_stored_as_mavlink_carries_it_is_the_same(plan, ardupilot):
    for part in (MISSION, FENCE, RALLY):
        items = items_of(plan, part, ardupilot)
        assert differences(part, items, [stored(item) for item in items], len(items), ardupilot) == ()


@given(plan=flight_plans(), data=st.data())
def test_whatever_else_is_changed_is_found(plan, data):
    items = items_of(plan, MISSION, ardupilot=False)
    number = data.draw(st.integers(0, len(items) - 1))
    item = items[number]
    spoilt = data.draw(
        st.sampled_from(
            [
                {"lat": item.lat + 3e-7},
                {"lon": item.lon - 3e-7},
                {"altitude_m": item.altitude_m * 1.00001 + 0.001},
                {"command": item.command + 1},
                {"settings": (1.0 + 2 * (item.settings[0] or 0.0), *item.settings[1:])},
                {"settings": (*item.settings[:2], None, item.settings[3])},
            ]
        )
    )
    back = [*items[:number], replace(item, **spoilt), *items[number + 1 :]]
    (told,) = differences(MISSION, items, back, len(items), ardupilot=False)
    assert told.startswith(f"mission item {number} (")


@given(plan=flight_plans())
def test_fences_are_whole_rings_one_after_the_other(plan):
    corners = items_of(plan, FENCE, ardupilot=True)
    at = 0
    for fence in plan.fences:
        ring = corners[at : at + len(fence.corners)]
        assert {item.settings[0] for item in ring} == {float(len(ring))}
        assert {item.command for item in ring} == {5001 if fence.inclusion else 5002}
        assert tuple((item.lat, item.lon) for item in ring) == fence.corners
        at += len(ring)
    assert at == len(corners)
