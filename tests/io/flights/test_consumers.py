"""Files as programs read them that are not ours: MAVSDK, pymavlink and GDAL."""

import socket
import struct
from contextlib import closing, contextmanager, redirect_stdout
from dataclasses import replace
from io import StringIO
from queue import Queue

import mavsdk
import numpy as np
import pyogrio
import pytest
from hypothesis import given, settings
from mavsdk.plugins.mission_raw import MissionRaw
from mavsdk.plugins.mission_raw_server import MissionRawServer

from sooner.io.flights import FORMATS, Aircraft
from sooner.missions.exported import export
from sooner.missions.flight_plans import flights
from tests.io.flights.plans import HOSTILE, RIDGE, flight_plans, named
from tests.missions.leg_missions import leg_mission, there_and_back

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # within pymavlink

TAKEOFF, SPEED, WAYPOINT, RETURN, LAND, LOITER = 22, 178, 16, 20, 21, 17
ANSWERS = ["MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK"]
NEAR = 1e-7  # degrees


def written(name, *plans):
    return FORMATS[name].write(plans, Aircraft())


def close(found, places):
    np.testing.assert_allclose(found, places, atol=NEAR, rtol=0)


# ---------------------------------------------------------------- MAVSDK


@pytest.fixture(scope="module")
def link():
    """An autopilot with a mission server and a ground station, which talk over the loopback."""
    port = _free_port()
    with _mavsdk(mavsdk.ComponentType.AUTOPILOT) as pilot, _mavsdk(mavsdk.ComponentType.GROUND_STATION) as ground:
        assert ground.add_any_connection(f"udpin://127.0.0.1:{port}") == 0
        assert pilot.add_any_connection(f"udpout://127.0.0.1:{port}") == 0
        server, taken = _mission_server(pilot)
        system = ground.first_autopilot(30.0)
        assert system is not None
        missions = MissionRaw(system)
        yield missions, taken
        missions.destroy()
        server.destroy()


def _free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def _mission_server(pilot):
    """A server that takes missions, and the missions that it has taken."""
    server, taken = MissionRawServer(pilot.server_component()), Queue()
    server.subscribe_incoming_mission(lambda result, mission, _: taken.put(mission.mission_items))
    return server, taken


@contextmanager
def _mavsdk(kind):
    made = mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(kind))
    try:
        yield made
    finally:
        made.destroy()


def places_of(items, command=WAYPOINT):
    return [(item.x / 1e7, item.y / 1e7) for item in items if item.command == command]


@settings(max_examples=25)
@given(plan=flight_plans())
def test_mavsdk_reads_a_plan_of_qgroundcontrol(link, plan):
    read = link[0].import_qgroundcontrol_mission_from_string(written("qgc", plan).decode())
    close(places_of(read.mission_items), plan.places)
    close(places_of(read.mission_items, TAKEOFF), [plan.home])
    assert {item.frame for item in read.mission_items if item.command in (TAKEOFF, WAYPOINT)} == {3}
    flown = [item for item in read.mission_items if item.command == WAYPOINT]
    np.testing.assert_allclose([item.z for item in flown], [each.altitude_m for each in plan.waypoints], atol=1e-3)
    np.testing.assert_allclose([item.param1 for item in flown], [each.hold_s for each in plan.waypoints], atol=1e-3)
    assert np.isnan([item.param4 for item in flown]).all()
    assert read.mission_items[-1].command == {"return": RETURN, "land": LAND, "loiter": LOITER}[plan.finish]
    corners = [(corner, 5001 if fence.inclusion else 5002) for fence in plan.fences for corner in fence.corners]
    close([(item.x / 1e7, item.y / 1e7) for item in read.geofence_items] or np.zeros((0, 2)), _points(corners))
    assert [item.command for item in read.geofence_items] == [command for _, command in corners]
    close(places_of(read.rally_items, 5100) or np.zeros((0, 2)), np.reshape(plan.landings, (-1, 2)))


def _points(corners):
    return np.reshape([corner for corner, _ in corners], (-1, 2))


@settings(max_examples=25)
@given(plan=flight_plans())
def test_mavsdk_reads_waypoints_of_mission_planner(link, plan):
    read = link[0].import_mission_planner_mission_from_string(written("waypoints", plan).decode())
    home, *flown = places_of(read.mission_items)
    close([home], [plan.home])
    close(flown, plan.places)
    assert read.mission_items[0].frame == 0
    assert [item.seq for item in read.mission_items] == list(range(len(read.mission_items)))


def test_an_autopilot_takes_the_mission_and_tells_it_back(link):
    missions, taken = link
    items = missions.import_qgroundcontrol_mission_from_string(written("qgc", RIDGE).decode()).mission_items
    missions.upload_mission(items)  # raises unless it is acknowledged
    close(places_of(missions.download_mission()), RIDGE.places)
    assert [item.command for item in missions.download_mission()] == [22, 178, 16, 16, 178, 16, 178, 16, 20]
    assert len(taken.get(timeout=30)) == len(items)


def test_a_speed_is_over_ground_and_leaves_the_throttle(link):
    items = link[0].import_qgroundcontrol_mission_from_string(written("qgc", RIDGE).decode()).mission_items
    told = [(item.param1, item.param2, item.param3) for item in items if item.command == SPEED]
    assert told == [(1.0, 12.0, -1.0), (1.0, 6.0, -1.0), (1.0, 12.0, -1.0)]


# ---------------------------------------------------------------- pymavlink


def test_an_autopilot_takes_what_pymavlink_uploads_from_our_waypoints(tmp_path):
    """COUNT -> REQUEST -> ITEM -> ACK, with a ground station and an autopilot that are both not ours."""
    from pymavlink import mavutil, mavwp

    path, port = tmp_path / "flight.waypoints", _free_port()
    path.write_bytes(written("waypoints", RIDGE))
    loader = mavwp.MAVWPLoader()
    with redirect_stdout(StringIO()):
        loader.load(str(path))
        ground = mavutil.mavlink_connection(f"udpin:127.0.0.1:{port}", dialect="common")
    with _mavsdk(mavsdk.ComponentType.AUTOPILOT) as pilot, closing(ground):
        server, taken = _mission_server(pilot)
        assert pilot.add_any_connection(f"udpout://127.0.0.1:{port}") == 0
        assert ground.wait_heartbeat(timeout=30) is not None
        ground.mav.mission_count_send(1, 1, loader.count())
        while (asked := ground.recv_match(type=ANSWERS, timeout=30, blocking=True)).get_type() != "MISSION_ACK":
            item = loader.wp(asked.seq)
            place = round(item.x * 1e7), round(item.y * 1e7), item.z
            flags = item.frame, item.command, item.current, item.autocontinue
            settings_ = item.param1, item.param2, item.param3, item.param4
            ground.mav.mission_item_int_send(1, 1, asked.seq, *flags, *settings_, *place)
        assert asked.type == mavutil.mavlink.MAV_MISSION_ACCEPTED
        close(places_of(taken.get(timeout=30)), [RIDGE.home, *RIDGE.places])
        server.destroy()


@settings(max_examples=20)
@given(plan=flight_plans())
def test_pymavlink_loads_waypoints(tmp_path_factory, plan):
    from pymavlink import mavwp

    path = tmp_path_factory.mktemp("pymavlink") / "flight.waypoints"
    path.write_bytes(written("waypoints", plan))
    loader = mavwp.MAVWPLoader()
    with redirect_stdout(StringIO()):
        count = loader.load(str(path))
    items = [loader.wp(number) for number in range(count)]
    assert [item.seq for item in items] == list(range(count))
    close([(item.x, item.y) for item in items if item.command == WAYPOINT], [plan.home, *plan.places])
    np.testing.assert_allclose(
        [item.z for item in items if item.command == WAYPOINT][1:],
        [each.altitude_m for each in plan.waypoints],
        atol=1e-3,
    )


# ---------------------------------------------------------------- GDAL


def gdal(path, layer=None):
    """Rows of a layer: its fields by name, and its points, longitude first."""
    meta, _, shapes, columns = pyogrio.raw.read(path, layer=layer, force_2d=True)
    rows = zip(*columns, strict=True) if len(columns) else [()] * len(shapes)
    fields = [dict(zip(meta["fields"], row, strict=True)) for row in rows]
    return [(told, None if shape is None else _well_known(shape)) for told, shape in zip(fields, shapes, strict=True)]


def _well_known(shape):
    """Points of a point, a line or the outer ring of a polygon in well-known binary; latitude first."""
    order = "<" if shape[0] else ">"
    (kind,) = struct.unpack_from(order + "I", shape, 1)
    start, count = {1: (5, 1), 2: (9, None), 3: (13, None)}[kind]
    if count is None:
        (count,) = struct.unpack_from(order + "I", shape, start - 4)
    return np.frombuffer(shape, order + "f8", 2 * count, start).reshape(-1, 2)[:, ::-1]


@pytest.fixture
def beside(tmp_path):
    def write(name, *plans):
        path = tmp_path / f"flight{FORMATS[name].suffix}"
        path.write_bytes(written(name, *plans))
        return path

    return write


VALLEY = replace(RIDGE, name="valley", searcher=1, waypoints=RIDGE.waypoints[:2])


def test_gdal_reads_gpx(beside):
    path = beside("gpx", RIDGE, VALLEY)
    routes = gdal(path, "routes")
    assert [told["name"] for told, _ in routes] == ["ridge", "valley"]
    close(routes[0][1], RIDGE.places)
    close(routes[1][1], VALLEY.places)
    (told, home), _ = gdal(path, "waypoints")
    assert told["name"] == "ridge: home"
    close(home, [RIDGE.home])


def test_gdal_reads_kml(beside):
    path = beside("kml", RIDGE, VALLEY)
    assert [name for name, _ in pyogrio.list_layers(path)] == ["ridge", "valley"]
    told = {row["Name"]: points for row, points in gdal(path, "ridge")}
    close(told["ridge"], RIDGE.places)
    close(told["ridge: home"], [RIDGE.home])
    close(told["stay inside"][:-1], RIDGE.fences[0].corners)
    close(told["stay out"][:-1], RIDGE.fences[1].corners)


def test_gdal_reads_both_parts_of_a_kmz(beside, tmp_path):
    import zipfile

    path = beside("dji", RIDGE)
    template = gdal(f"/vsizip/{path}/wpmz/template.kml")
    close(np.concatenate([points for _, points in template]), RIDGE.places)
    with zipfile.ZipFile(path) as archive:
        (tmp_path / "waylines.kml").write_bytes(archive.read("wpmz/waylines.wpml"))
    close(np.concatenate([points for _, points in gdal(tmp_path / "waylines.kml")]), RIDGE.places)


def test_gdal_reads_geojson(beside):
    rows = gdal(beside("caltopo", RIDGE, VALLEY))
    assert [told["class"] for told, _ in rows] == [*["Folder", "Shape", "Marker", "Marker", "Shape", "Shape"] * 2]
    close(rows[1][1], RIDGE.places)
    close(rows[2][1], [RIDGE.home])
    close(rows[4][1][:-1], RIDGE.fences[0].corners)
    close(rows[7][1], VALLEY.places)


@pytest.mark.parametrize("hostile", HOSTILE, ids=range(len(HOSTILE)))
def test_gdal_takes_any_name_for_text(beside, hostile):
    (told, _), *_ = gdal(beside("gpx", named(hostile)), "routes")
    assert (told["name"] or "") == hostile
    rows = gdal(beside("caltopo", named(hostile)))
    assert rows[1][0]["title"] == hostile
    close(rows[1][1], RIDGE.places)
    (layer, _), *_ = pyogrio.list_layers(beside("kml", named(hostile)))
    close(gdal(beside("kml", named(hostile)), layer)[0][1], RIDGE.places)


# ---------------------------------------------------------------- sorties along legs


@pytest.fixture
def sorties(tmp_path):
    """Two drones over hills, two batteries each, as a mission's plan is exported."""
    path = leg_mission(tmp_path, 2, 2, True, "[wind]\nspeed_mps = 6\nfrom_deg = 250")
    score = there_and_back(path, [[200, 900], [800, 900], [800, 100]], [[1400, 900], [1400, 300]])
    return score, flights(score).plans


def test_an_autopilot_takes_every_sortie_and_tells_it_back(link, sorties):
    missions, _ = link
    for plan in sorties[1]:
        read = missions.import_qgroundcontrol_mission_from_string(written("qgc", plan).decode())
        missions.upload_mission(read.mission_items)  # raises unless it is acknowledged
        back = missions.download_mission()
        close(places_of(back), plan.places)
        heights = [item.z for item in back if item.command == WAYPOINT]
        np.testing.assert_allclose(heights, [each.altitude_m for each in plan.waypoints], atol=1e-3)
        corners = [corner for fence in plan.fences for corner in fence.corners]
        close([(item.x / 1e7, item.y / 1e7) for item in read.geofence_items], corners)


def test_pymavlink_and_gdal_read_every_sortie(sorties, tmp_path):
    from pymavlink import mavwp

    score, plans = sorties
    made = export(score, ["waypoints", "gpx", "kml", "caltopo", "geotiff"]).files
    for name, content in made.items():
        (tmp_path / name).write_bytes(content)
    for number, plan in enumerate(plans):
        loader = mavwp.MAVWPLoader()
        with redirect_stdout(StringIO()):
            count = loader.load(str(tmp_path / f"flight-{number}.waypoints"))
        items = [loader.wp(each) for each in range(count)]
        close([(item.x, item.y) for item in items if item.command == WAYPOINT], [plan.home, *plan.places])
    routes = gdal(tmp_path / "flight.gpx", "routes")
    assert [told["name"] for told, _ in routes] == [plan.name for plan in plans]
    for (_, points), plan in zip(routes, plans, strict=True):
        close(points, plan.places)
    layers = [name for name, _ in pyogrio.list_layers(tmp_path / "flight.kml")]
    assert layers == [plan.name for plan in plans]
    close(gdal(tmp_path / "flight.kml", layers[2])[0][1], plans[2].places)
    lines = [points for told, points in gdal(tmp_path / "flight.geojson") if told["title"] in layers]
    close(next(points for points in lines if points is not None and len(points) > 1), plans[0].places)
    import rasterio

    with rasterio.open(tmp_path / "pod.tif") as source:
        assert source.read(1).max() == pytest.approx(1.0)
