"""Uploads to a scripted vehicle that does all that vehicles do to them."""

import dataclasses
import math
import signal
import socket
import sys
import threading
import time

import pytest

from sooner.errors import DataFormatError, UnsupportedProblemError
from sooner.io.mavlink import Connection, Patience, VehicleError, upload
from tests.io.flights.plans import RIDGE
from tests.io.mavlink.scripted_vehicle import (
    ARDUPILOT,
    GENERIC,
    HASTE,
    PX4,
    as_ardupilot_keeps,
    changed,
    flying,
)

BARE = dataclasses.replace(RIDGE, fences=(), landings=())


def sent_to(vehicle, plan=RIDGE, **options):
    options = {"patience": HASTE} | options
    return upload(plan, Connection.of(f"udpout:127.0.0.1:{vehicle.port}"), **options)


def held(vehicle, kind=0, command=16):
    return [(item.x, item.y) for item in vehicle.lists[kind] if item.command == command]


def units(places):
    return [(round(lat * 1e7), round(lon * 1e7)) for lat, lon in places]


def lists(uploaded):
    return [(each.part, each.sent, each.held) for each in uploaded.checked]


# ---------------------------------------------------------------- as it should be


def test_a_vehicle_holds_the_flight_with_its_fence_and_rally_points():
    with flying() as vehicle:
        uploaded = sent_to(vehicle)
    assert uploaded.same
    assert lists(uploaded) == [("fence", 7, 7), ("rally points", 1, 1), ("mission", 9, 9)]
    assert held(vehicle) == units(RIDGE.places)
    assert [item.command for item in vehicle.lists[0]] == [22, 178, 16, 16, 178, 16, 178, 16, 20]
    assert held(vehicle, 1, 5001) == units(RIDGE.fences[0].corners)
    assert held(vehicle, 1, 5002) == units(RIDGE.fences[1].corners)
    assert [item.param1 for item in vehicle.lists[1]] == [4.0] * 4 + [3.0] * 3
    assert held(vehicle, 2, 5100) == units(RIDGE.landings)
    assert all(math.isnan(item.param4) for item in vehicle.lists[0] if item.command == 16)
    assert [item.current for item in vehicle.lists[0]] == [1] + [0] * 8
    assert any("GF_ACTION" in note for note in uploaded.notes)


def test_it_is_never_armed_nor_started():
    with flying() as vehicle:
        sent_to(vehicle)
    assert set(vehicle.commands) <= {512, 520}  # questions
    assert set(vehicle.heard) == {
        "HEARTBEAT", "COMMAND_LONG", "MISSION_COUNT", "MISSION_ITEM_INT", "MISSION_ACK",
        "MISSION_REQUEST_LIST", "MISSION_REQUEST_INT",
    }  # fmt: skip


def test_ardupilot_is_told_home_first_and_may_keep_things_its_own_way():
    for finish in ("return", "land", "loiter"):
        plan = dataclasses.replace(RIDGE, finish=finish)
        with flying(autopilot=ARDUPILOT, keeps=as_ardupilot_keeps) as vehicle:
            uploaded = sent_to(vehicle, plan)
        assert uploaded.same, uploaded.checked
        assert lists(uploaded)[-1] == ("mission", 10, 10)
        assert not any(math.isnan(item.param4) for item in vehicle.lists[0])
        assert any("FENCE_ENABLE" in note for note in uploaded.notes)
        assert not any("home" in note for note in uploaded.notes)


def test_ardupilot_whose_home_is_elsewhere_is_told_of():
    def elsewhere(number, item):
        return changed(item, x=460_100_000) if number == 0 and item.mission_type == 0 else item

    with flying(autopilot=ARDUPILOT, keeps=elsewhere) as vehicle:
        uploaded = sent_to(vehicle)
    assert uploaded.same
    assert "the vehicle's home is 1,112 m from where the flight begins" in uploaded.notes
    with flying(autopilot=ARDUPILOT, keeps=lambda n, item: changed(item, x=0, y=0) if n == 0 else item) as vehicle:
        assert "the vehicle does not know its home yet" in sent_to(vehicle, BARE).notes


def test_half_seconds_and_half_metres_that_ardupilot_cannot_keep_are_rounded_up():
    waypoints = (dataclasses.replace(RIDGE.waypoints[0], hold_s=2.25, altitude_m=60.5),)
    with flying(autopilot=ARDUPILOT, keeps=as_ardupilot_keeps) as vehicle:
        assert sent_to(vehicle, dataclasses.replace(RIDGE, waypoints=waypoints)).same
    assert [item.param1 for item in vehicle.lists[0] if item.command == 16] == [0.0, 3.0]
    assert vehicle.lists[2][0].z == 61.0


def test_an_autopilot_can_be_named():
    with flying(autopilot=GENERIC) as vehicle:
        assert lists(sent_to(vehicle, BARE, autopilot=ARDUPILOT))[-1] == ("mission", 10, 10)
        assert lists(sent_to(vehicle, BARE))[-1] == ("mission", 9, 9)


def test_a_vehicle_that_sends_to_a_port_of_ours_is_answered():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with flying(ground=("127.0.0.1", port)):
        assert upload(RIDGE, Connection.of(f"udp:127.0.0.1:{port}"), patience=HASTE).same


# ---------------------------------------------------------------- links and vehicles as they are


@pytest.mark.parametrize(
    "script",
    [
        {"asks": "mission_request"},
        {"asks_twice": True},
        {"asks": "mission_request", "asks_twice": True, "autopilot": ARDUPILOT},
        {"loses": 0.15},
        {"garbage": True},
        {"busy": 2, "autopilot": ARDUPILOT},
        {"forgets_acks": 2},
        {"capabilities": None},
        {"loses": 0.1, "garbage": True, "asks_twice": True, "busy": 2},
    ],
    ids=str,
)
def test_what_vehicles_and_links_do_is_borne(script):
    patient = dataclasses.replace(HASTE, tries=20, answer_s=0.1, silence_s=0.5)
    with flying(**script) as vehicle:
        uploaded = sent_to(vehicle, patience=patient)
    assert uploaded.same
    assert held(vehicle)[-4:] == units(RIDGE.places)
    assert held(vehicle, 1, 5001) == units(RIDGE.fences[0].corners)


def test_a_vehicle_without_space_is_asked_only_so_often():
    with flying(busy=10**6) as vehicle, pytest.raises(VehicleError, match=r"no space for so many items.*RESULT 4"):
        sent_to(vehicle, BARE, patience=dataclasses.replace(HASTE, busy_tries=3))
    assert vehicle.heard["MISSION_COUNT"] == 4


@pytest.mark.parametrize(
    ("result", "told"),
    [
        (1, "does not say why"),
        (2, "altitudes count from"),
        (10, "a latitude is not valid"),
        (14, "takes none now"),
        (99, "99"),
    ],
)
def test_a_refusal_is_told_in_words(result, told):
    with flying(refuses={0: result}) as vehicle, pytest.raises(VehicleError, match=told) as refused:
        sent_to(vehicle, BARE)
    assert refused.value.result == result
    assert "vehicle 1: mission: the vehicle refused" in str(refused.value)
    assert "PX4 keeps its old mission" in str(refused.value)


def test_a_vehicle_that_falls_silent_half_way_ends_the_upload():
    begun = time.monotonic()
    with flying(silent_after=4) as vehicle, pytest.raises(VehicleError, match="fell silent at item 3 of 9") as refused:
        sent_to(vehicle, BARE, patience=dataclasses.replace(HASTE, tries=2))
    assert refused.value.result is None
    assert time.monotonic() - begun < 60.0


def test_ardupilot_that_falls_silent_may_hold_a_part_of_both():
    with (
        flying(autopilot=ARDUPILOT, silent_after=4) as vehicle,
        pytest.raises(VehicleError, match="part of the old: upl"),
    ):
        sent_to(vehicle, BARE, patience=dataclasses.replace(HASTE, tries=1))


def test_a_vehicle_that_asks_for_ever_is_not_answered_for_ever():
    with flying() as vehicle:
        vehicle._on_mission_item_int = lambda message: vehicle._ask()
        with pytest.raises(VehicleError, match="fell silent"):
            sent_to(vehicle, BARE, patience=dataclasses.replace(HASTE, tries=1))
    assert vehicle.heard["MISSION_ITEM_INT"] <= 20 * 9 + 100


def test_a_vehicle_that_is_not_there_is_told_of():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as nobody:
        nobody.bind(("127.0.0.1", 0))
        address = Connection.of(f"udpout:127.0.0.1:{nobody.getsockname()[1]}")
        with pytest.raises(
            DataFormatError, match=r"no heartbeat came within 0\.2 s; expected a vehicle that is switched on"
        ):
            upload(RIDGE, address, patience=dataclasses.replace(HASTE, heartbeat_s=0.2))


def test_one_of_several_vehicles_must_be_named():
    with flying(systems=(3, 7)) as vehicle:
        with pytest.raises(DataFormatError, match="heartbeats of vehicles 3, 7 came; expected --system"):
            sent_to(vehicle)
        assert sent_to(vehicle, system=3).vehicle.system == 3
        with pytest.raises(DataFormatError, match="no heartbeat of vehicle 9"):
            sent_to(vehicle, system=9, patience=dataclasses.replace(HASTE, heartbeat_s=0.3))


def test_what_the_vehicle_warns_of_is_passed_on_without_harm():
    with flying(says=b"PreArm: \x1b[31mcompass") as vehicle:
        patience = dataclasses.replace(HASTE, warnings_s=1.0)
        assert r"the vehicle says: PreArm: \x1b[31mcompass" in sent_to(vehicle, BARE, patience=patience).notes


# ---------------------------------------------------------------- what must not happen


def test_an_armed_vehicle_keeps_its_mission_unless_forced():
    with flying(armed=True, held={0: 5}) as vehicle:
        with pytest.raises(DataFormatError, match=r"vehicle 1: an armed vehicle came; .*--force"):
            sent_to(vehicle)
        assert len(vehicle.lists[0]) == 5
        assert "MISSION_COUNT" not in vehicle.heard
        forced = sent_to(vehicle, force=True)
    assert forced.same
    assert "the vehicle is armed" in forced.notes


def test_a_vehicle_that_is_armed_meanwhile_keeps_its_mission():
    with flying(arms_after=3, held={0: 5}) as vehicle, pytest.raises(DataFormatError, match="an armed vehicle came"):
        sent_to(vehicle)
    assert len(vehicle.lists[0]) == 5


@pytest.mark.parametrize(
    ("fields", "told"),
    [
        ({"x": 460_000_123}, "mission item 2 (waypoint): latitude 46.0000000 was sent, 46.0000123 came back"),
        ({"y": 110_000_002}, "longitude 11.0000000 was sent, 11.0000002 came back"),
        ({"z": 60.001}, "altitude 60 was sent, 60.001 came back"),
        ({"z": math.nan}, "altitude 60 was sent, nan came back"),
        ({"frame": 0}, "frame 3 was sent, 0 came back"),
        ({"command": 17}, "command 16 was sent, 17 came back"),
        ({"param1": 1.0}, "parameter 1 0 was sent, 1 came back"),
        ({"param2": math.nan}, "parameter 2 0 was sent, nothing came back"),
    ],
)
def test_what_was_stored_otherwise_is_found(fields, told):
    def spoilt(number, item):
        return changed(item, **fields) if number == 2 else item

    with flying(keeps=spoilt) as vehicle:
        uploaded = sent_to(vehicle, BARE)
    assert not uploaded.same
    (difference,) = uploaded.checked[-1].differences
    assert told in difference


def test_one_unit_of_position_is_no_difference():
    with flying(keeps=lambda number, item: changed(item, x=item.x + 1, y=item.y - 1)) as vehicle:
        assert sent_to(vehicle).same


def test_items_that_are_lost_are_found():
    with flying() as vehicle:
        vehicle._on_mission_request_list = lambda message: _counts(vehicle, message, -1)
        uploaded = sent_to(vehicle, BARE)
        assert "mission: 9 items were sent, the vehicle holds 8" in uploaded.checked[-1].differences
        vehicle._on_mission_request_list = lambda message: _counts(vehicle, message, 60_000)
        assert not sent_to(vehicle, BARE).same


def _counts(vehicle, message, more):
    from pymavlink.dialects.v20 import common

    count = len(vehicle.lists[message.mission_type]) + (more if message.mission_type == 0 else 0)
    vehicle._send(common.MAVLink_mission_count_message(254, 190, count, message.mission_type))


# ---------------------------------------------------------------- fences and rally points


def test_a_fence_of_another_flight_is_cleared():
    with flying(held={1: 6, 2: 1}) as vehicle:
        uploaded = sent_to(vehicle, BARE)
    assert vehicle.lists[1] == vehicle.lists[2] == []
    assert lists(uploaded)[:2] == [("fence", 0, 0), ("rally points", 0, 0)]
    assert "fence: the vehicle held 6 items of another flight, which were cleared" in uploaded.notes
    assert "rally points: the vehicle held 1 items of another flight, which were cleared" in uploaded.notes


def test_a_fence_that_does_not_go_away_is_a_difference():
    with flying(held={1: 6}) as vehicle:
        vehicle._on_mission_clear_all = lambda message: vehicle._acknowledge(1, 0)
        uploaded = sent_to(vehicle, BARE)
    assert uploaded.checked[0].differences == (
        "fence: the vehicle was told to clear this list, and still holds 6 items",
    )


@pytest.mark.parametrize(
    ("script", "why"),
    [
        ({"capabilities": 0}, ""),
        ({"capabilities": None, "refuses": {1: 3, 2: 3}}, ""),
        ({"version_1": True, "capabilities": None}, ", as it speaks MAVLink 1"),
    ],
)
def test_a_vehicle_without_fences_gets_the_mission_and_it_is_told(script, why):
    with flying(**script) as vehicle:
        uploaded = sent_to(vehicle)
    assert uploaded.same
    assert [each.part for each in uploaded.checked] == ["mission"]
    assert f"the vehicle takes no fence{why}: the flight's 7 items were not sent" in uploaded.notes
    assert f"the vehicle takes no rally points{why}: the flight's 1 items were not sent" in uploaded.notes


def test_a_vehicle_that_is_silent_about_fences_and_about_itself_gets_the_mission():
    with flying(capabilities=None) as vehicle:
        told = vehicle._on_mission_request_list
        vehicle._on_mission_request_list = lambda message: None if message.mission_type else told(message)
        uploaded = sent_to(vehicle, patience=dataclasses.replace(HASTE, answer_s=0.2, tries=3))
    assert uploaded.same
    assert [each.part for each in uploaded.checked] == ["mission"]


def test_a_mission_that_is_refused_says_that_the_fence_is_the_new_one():
    with (
        flying(refuses={0: 14}) as vehicle,
        pytest.raises(VehicleError, match="; replaced before: fence, rally points"),
    ):
        sent_to(vehicle)


def test_a_fence_that_is_refused_stops_the_upload_before_the_mission():
    with (
        flying(refuses={1: 5}, held={0: 3}) as vehicle,
        pytest.raises(VehicleError, match="fence: the vehicle refused"),
    ):
        sent_to(vehicle)
    assert len(vehicle.lists[0]) == 3


# ---------------------------------------------------------------- Ctrl-C


@pytest.mark.skipif(sys.platform == "win32", reason="signals of one thread")
@pytest.mark.parametrize(
    ("autopilot", "told"),
    [
        (PX4, "PX4 keeps its old mission until"),
        (ARDUPILOT, "the vehicle may hold a part of the new mission and a part"),
    ],
)
def test_an_interruption_half_way_is_told_to_the_vehicle_and_to_the_pilot(autopilot, told):
    with flying(autopilot=autopilot, held={0: 5}) as vehicle:
        vehicle._on_mission_item_int = lambda message: signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
        with pytest.raises(KeyboardInterrupt, match=f"interrupted while the mission was sent: {told}"):
            sent_to(vehicle, BARE, patience=Patience(neighbours_s=0.1))
        until = time.monotonic() + 10.0
        while vehicle.taking is not None and time.monotonic() < until:
            time.sleep(0.01)
    assert vehicle.taking is None
    assert len(vehicle.lists[0]) == 5


def test_an_interruption_before_that_changes_no_mission():
    def interrupt(line):
        if line.startswith("vehicle"):
            raise KeyboardInterrupt

    with flying(held={0: 5}) as vehicle, pytest.raises(KeyboardInterrupt, match="the vehicle's mission is as it was"):
        sent_to(vehicle, tell=interrupt)
    assert len(vehicle.lists[0]) == 5


def test_an_interruption_while_it_is_read_back_says_that_it_is_not_checked():
    def interrupt(message):
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)

    with flying() as vehicle:
        vehicle._on_mission_request_int = interrupt
        told = "while the fence was read back: the vehicle took it, and it is not checked; its mission is as it was"
        with pytest.raises(KeyboardInterrupt, match=told):
            sent_to(vehicle, patience=Patience(neighbours_s=0.1))


def test_a_mission_that_cannot_be_read_back_is_told_of():
    with flying() as vehicle:
        vehicle._on_mission_request_int = lambda message: None
        with pytest.raises(
            VehicleError, match=r"did not say item 0 of 9, asked 2 times.*took it, and it is not checked"
        ):
            sent_to(vehicle, BARE, patience=dataclasses.replace(HASTE, tries=2))


# ---------------------------------------------------------------- without pymavlink


def test_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pymavlink.dialects.v20", None)
    with pytest.raises(UnsupportedProblemError, match=r"pip install 'sooner\[aircraft\]'"):
        upload(RIDGE, Connection.of("udpout:127.0.0.1:9"))
