"""Uploads to autopilots that are not ours.

MAVSDK's autopilot runs within the tests. SOONER_AUTOPILOT may name the connection of a simulated one, disarmed, which
then gets a flight and keeps it: SOONER_AUTOPILOT=tcp:127.0.0.1:5760 for ArduPilot's SITL, udp:127.0.0.1:14550 for
what MAVProxy or PX4's SITL sends there. Without it that test skips.
"""

import os
import socket
from contextlib import contextmanager
from dataclasses import replace
from queue import Queue

import mavsdk
import numpy as np
import pytest
from mavsdk.plugins.mission_raw_server import MissionRawServer

from sooner.io.mavlink import Connection, upload
from tests.io.flights.plans import RIDGE

COMMANDS = [[5001] * 4 + [5002] * 3, [5100], [22, 178, 16, 16, 178, 16, 178, 16, 20]]


@contextmanager
def autopilot():
    """An autopilot with a mission server that sends to a port of ours, and the lists that it has taken."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    pilot = mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.AUTOPILOT))
    assert pilot.add_any_connection(f"udpout://127.0.0.1:{port}") == 0
    server, taken = MissionRawServer(pilot.server_component()), Queue()
    server.subscribe_incoming_mission(lambda result, mission, _: taken.put(mission.mission_items))
    try:
        yield Connection.of(f"udp:127.0.0.1:{port}"), taken
    finally:
        server.destroy()
        pilot.destroy()


def test_mavsdk_takes_the_flight_acknowledges_it_and_tells_it_back():
    with autopilot() as (connection, taken):
        uploaded = upload(RIDGE, connection)
        fence, rally, mission = (taken.get(timeout=30) for _ in range(3))
        without = upload(replace(RIDGE, fences=(), landings=()), connection)
    assert uploaded.same
    assert [(each.part, each.sent, each.held) for each in uploaded.checked] == [
        ("fence", 7, 7),
        ("rally points", 1, 1),
        ("mission", 9, 9),
    ]
    assert [[item.command for item in each] for each in (fence, rally, mission)] == COMMANDS
    assert without.same
    assert "fence: the vehicle held 7 items of another flight, which were cleared" in without.notes
    corners = [corner for ring in RIDGE.fences for corner in ring.corners]
    for items, places in ((fence, corners), (rally, RIDGE.landings), (mission, RIDGE.places)):
        found = [(item.x / 1e7, item.y / 1e7) for item in items if item.command in (16, 5001, 5002, 5100)]
        np.testing.assert_allclose(found, places, atol=1e-7, rtol=0)


@pytest.mark.skipif("SOONER_AUTOPILOT" not in os.environ, reason="SOONER_AUTOPILOT names no simulated autopilot")
def test_a_simulated_autopilot_keeps_what_it_was_sent():
    uploaded = upload(RIDGE, Connection.of(os.environ["SOONER_AUTOPILOT"]))
    assert uploaded.checked[-1].part == "mission"
    assert uploaded.same, uploaded.checked
