"""Every format: the same places come back, names stay text, the same flight is the same file."""

import io
import json
import zipfile
from dataclasses import replace
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings

from sooner.errors import UnsupportedProblemError
from sooner.io.flights import DJI_MODELS, FORMATS, Aircraft
from sooner.missions.flight_plans import flights
from tests.io.flights.plans import HOSTILE, RIDGE, UNSAYABLE, flight_plans, named
from tests.missions.leg_missions import leg_mission, there_and_back

NEAR = 1e-7  # degrees; MAVLink tells no finer
KML = "{http://www.opengis.net/kml/2.2}"
WPML = "{http://www.dji.com/wpmz/1.0.2}"
GPX = "{http://www.topografix.com/GPX/1/1}"


def written(name, *plans, aircraft=None):
    return FORMATS[name].write(plans, aircraft or Aircraft())


def parts_of(kmz):
    with zipfile.ZipFile(io.BytesIO(kmz)) as archive:
        return {entry: ElementTree.fromstring(archive.read(entry)) for entry in archive.namelist()}


def lat_lon(coordinates):
    return tuple(float(each) for each in coordinates.split(",")[1::-1])


def qgc_places(data):
    items = json.loads(data)["mission"]["items"]
    return [tuple(item["params"][4:6]) for item in items if item["command"] == 16]


def waypoints_places(data):
    rows = [line.split("\t") for line in data.decode().splitlines()[2:]]
    assert {len(row) for row in rows} == {12}
    return [(float(row[8]), float(row[9])) for row in rows if row[3] == "16"]


def dji_places(data):
    placemarks = parts_of(data)["wpmz/waylines.wpml"].iter(f"{KML}Placemark")
    return [lat_lon(each.find(f"{KML}Point/{KML}coordinates").text) for each in placemarks]


def kml_places(data):
    (line,) = ElementTree.fromstring(data).iter(f"{KML}LineString")
    return [lat_lon(each) for each in line.find(f"{KML}coordinates").text.split()]


def gpx_places(data):
    return [
        (float(each.get("lat")), float(each.get("lon"))) for each in ElementTree.fromstring(data).iter(f"{GPX}rtept")
    ]


def caltopo_places(data):
    (line,) = [each for each in json.loads(data)["features"] if (each["geometry"] or {}).get("type") == "LineString"]
    return [(lat, lon) for lon, lat in line["geometry"]["coordinates"]]


def cot_places(data):
    return [tuple(map(float, each.get("point").split(",")[:2])) for each in ElementTree.fromstring(data).iter("link")]


READERS = {
    "qgc": qgc_places,
    "waypoints": waypoints_places,
    "dji": dji_places,
    "kml": kml_places,
    "gpx": gpx_places,
    "caltopo": caltopo_places,
    "cot": cot_places,
}


def test_every_format_is_read_back_here():
    assert set(READERS) == set(FORMATS)
    assert len({each.suffix for each in FORMATS.values()}) == len(FORMATS)


@pytest.mark.parametrize("name", READERS)
@settings(max_examples=25)
@given(plan=flight_plans(fewest=2, copters=True))
def test_the_same_places_come_back(name, plan):
    found = READERS[name](written(name, plan))
    assert len(found) == len(plan.waypoints)
    for place, waypoint in zip(found, plan.waypoints, strict=True):
        assert place == pytest.approx((waypoint.lat, waypoint.lon), abs=NEAR, rel=0)


@pytest.mark.parametrize("name", ["qgc", "waypoints", "kml", "gpx", "caltopo", "cot"])
@settings(max_examples=20)
@given(plan=flight_plans())
def test_any_flight_can_be_written_but_by_dji(name, plan):
    assert len(READERS[name](written(name, plan))) == len(plan.waypoints)


@pytest.mark.parametrize("name", READERS)
def test_the_same_flight_is_the_same_file(name):
    assert written(name, RIDGE) == written(name, replace(RIDGE))


@pytest.mark.parametrize("hostile", [*HOSTILE, UNSAYABLE], ids=range(len(HOSTILE) + 1))
def test_a_name_stays_text(hostile):
    plan = named(hostile)
    said = hostile if hostile != UNSAYABLE else "bell \ufffd, nul \ufffd, lone \ufffd, last \ufffd"
    for name in READERS:
        assert READERS[name](written(name, plan)) == READERS[name](written(name, RIDGE))
    document = ElementTree.fromstring(written("kml", plan))
    assert document.find(f"{KML}Document/{KML}Folder/{KML}name").text == (said or None)
    assert ElementTree.fromstring(written("gpx", plan)).find(f"{GPX}rte/{GPX}name").text == (said or None)
    assert ElementTree.fromstring(written("cot", plan)).find("detail/contact").get("callsign") == said
    assert json.loads(written("caltopo", plan))["features"][1]["properties"]["title"] == hostile


@pytest.mark.parametrize("name", [name for name, each in FORMATS.items() if not each.single])
def test_a_file_of_many_holds_every_flight(name):
    data = written(name, RIDGE, replace(RIDGE, name="valley", searcher=1))
    assert b"ridge" in data
    assert b"valley" in data


@pytest.mark.parametrize("name", [name for name, each in FORMATS.items() if each.single])
def test_a_file_of_one_takes_one(name):
    with pytest.raises(ValueError, match="values to unpack"):
        written(name, RIDGE, RIDGE)


# ---------------------------------------------------------------- one by one


def test_a_plan_has_all_that_qgroundcontrol_asks_for():
    told = json.loads(written("qgc", RIDGE, aircraft=Aircraft("px4")))
    assert {"fileType", "version", "groundStation", "mission", "geoFence", "rallyPoints"} == set(told)
    assert told["mission"]["firmwareType"] == 12
    assert told["mission"]["plannedHomePosition"] == [46.0, 11.0, 0.0]
    assert [item["doJumpId"] for item in told["mission"]["items"]] == list(range(1, 10))
    assert [item["command"] for item in told["mission"]["items"]] == [22, 178, 16, 16, 178, 16, 178, 16, 20]
    assert all(len(item["params"]) == 7 for item in told["mission"]["items"])
    assert told["mission"]["items"][3]["params"][0] == 4.0
    assert [fence["inclusion"] for fence in told["geoFence"]["polygons"]] == [True, False]
    assert told["rallyPoints"]["points"] == [[46.002, 11.001, 60.0]]


def test_waypoints_begin_with_home():
    lines = written("waypoints", replace(RIDGE, home_altitude_m=412.5)).decode().splitlines()
    assert lines[0] == "QGC WPL 110"
    assert lines[1].split("\t")[:4] == ["0", "1", "0", "16"]
    assert float(lines[1].split("\t")[10]) == 412.5
    assert [line.split("\t")[1] for line in lines[2:]] == ["0"] * 9


def test_gpx_tells_heights_only_above_the_sea():
    assert b"<ele>" not in written("gpx", RIDGE)
    route = ElementTree.fromstring(written("gpx", replace(RIDGE, home_altitude_m=400.0)))
    assert [float(each.text) for each in route.iter(f"{GPX}ele")] == [400.0, 460.0, 460.0, 475.5, 460.0]


def test_a_cursor_on_target_route_is_one():
    event = ElementTree.fromstring(written("cot", RIDGE))
    assert (event.tag, event.get("version"), event.get("type"), event.get("how")) == ("event", "2.0", "b-m-r", "h-e")
    assert event.get("start") == event.get("time") < event.get("stale")
    links = event.findall("detail/link")
    assert [each.get("type") for each in links] == ["b-m-p-w", "b-m-p-c", "b-m-p-c", "b-m-p-w"]
    assert len({each.get("uid") for each in links}) == 4


def test_caltopo_features_lie_in_the_folder_of_their_flight():
    features = json.loads(written("caltopo", RIDGE, replace(RIDGE, name="valley", searcher=1)))["features"]
    folders = [each["id"] for each in features if each["properties"]["class"] == "Folder"]
    assert len(set(folders)) == 2
    assert len({each["id"] for each in features}) == len(features)
    others = [each["properties"] for each in features if each["id"] not in folders]
    assert {each["class"] for each in others} == {"Shape", "Marker"}
    assert {each["folderId"] for each in others} == set(folders)


# What DJI's tables of template.kml, waylines.wpml and their common elements require, in order of reading.
CONFIG = {
    "flyToWaylineMode": {"safely", "pointToPoint"},
    "finishAction": {"goHome", "noAction", "autoLand", "gotoFirstWaypoint"},
    "exitOnRCLost": {"goContinue", "executeLostAction"},
    "executeRCLostAction": {"goBack", "landing", "hover"},
    "takeOffSecurityHeight": (1.2, 1500),
    "globalTransitionalSpeed": (0, 15),
}
TEMPLATE = ("templateType", "templateId", "waylineCoordinateSysParam", "autoFlightSpeed", "gimbalPitchMode")
TEMPLATE += ("globalWaypointHeadingParam", "globalWaypointTurnMode")
SHOWN = ("index", "ellipsoidHeight", "height", "useGlobalHeight", "useGlobalSpeed", "useGlobalHeadingParam")
LINE = ("templateId", "executeHeightMode", "waylineId", "autoFlightSpeed")
FLOWN = ("index", "executeHeight", "waypointSpeed", "waypointHeadingParam", "waypointTurnParam", "useStraightLine")


@pytest.mark.parametrize("model", DJI_MODELS)
def test_a_kmz_is_as_dji_has_published(model):
    parts = parts_of(written("dji", RIDGE, aircraft=Aircraft(dji=model)))
    assert list(parts) == ["wpmz/template.kml", "wpmz/waylines.wpml"]
    for root in parts.values():
        assert root.tag == f"{KML}kml"
        config = root.find(f"{KML}Document/{WPML}missionConfig")
        for name, values in CONFIG.items():
            said = config.find(f"{WPML}{name}").text
            assert said in values if isinstance(values, set) else values[0] <= float(said) <= values[1]
        assert int(config.find(f"{WPML}droneInfo/{WPML}droneEnumValue").text) == DJI_MODELS[model].drone
        payload = config.find(f"{WPML}payloadInfo/{WPML}payloadEnumValue")
        assert (payload is None) == (model in ("m300", "m350"))
        assert len(root.findall(f"{KML}Document/{KML}Folder")) == 1
    folders = {name: root.find(f"{KML}Document/{KML}Folder") for name, root in parts.items()}
    for name, asked, each in (("wpmz/template.kml", TEMPLATE, SHOWN), ("wpmz/waylines.wpml", LINE, FLOWN)):
        assert all(folders[name].find(f"{WPML}{tag}") is not None for tag in asked)
        placemarks = folders[name].findall(f"{KML}Placemark")
        assert [int(mark.find(f"{WPML}index").text) for mark in placemarks] == [0, 1, 2, 3]
        assert all(mark.find(f"{WPML}{tag}") is not None for mark in placemarks for tag in each)


def test_dji_flies_straight_stops_in_corners_and_hovers_where_the_plan_holds():
    marks = parts_of(written("dji", RIDGE))["wpmz/waylines.wpml"].findall(f".//{KML}Placemark")
    turns = {mark.find(f"{WPML}waypointTurnParam/{WPML}waypointTurnMode").text for mark in marks}
    assert turns == {"toPointAndStopWithDiscontinuityCurvature"}
    assert {mark.find(f"{WPML}useStraightLine").text for mark in marks} == {"1"}
    hovers = [mark.find(f".//{WPML}hoverTime") for mark in marks]
    assert [None if each is None else each.text for each in hovers] == [None, "4", None, None]
    assert [mark.find(f"{WPML}waypointSpeed").text for mark in marks] == ["12", "6", "12", "12"]  # of the leg onward


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"kind": "fixed_wing"}, "fixed wings"),
        ({"speed_mps": None}, "searcher.speed_mps"),
        ({"waypoints": RIDGE.waypoints[:1]}, "at least two"),
        ({"waypoints": (replace(RIDGE.waypoints[0], altitude_m=1600.0), RIDGE.waypoints[1])}, "1600 m high"),
        ({"waypoints": RIDGE.waypoints * 20_000}, "80,000 waypoints"),
        ({"name": "x" * 10_000, "speed_mps": None}, "xxx'... has no speed"),
    ],
)
def test_what_dji_cannot_fly_is_refused(wrong, told):
    with pytest.raises(UnsupportedProblemError, match=told):
        written("dji", replace(RIDGE, **wrong))


def test_dji_passes_what_lies_straight_ahead_and_stops_in_corners(tmp_path):
    score = there_and_back(leg_mission(tmp_path, 1, 1, True), [[200, 900], [800, 900], [800, 100]])
    (plan,) = flights(score).plans
    with zipfile.ZipFile(io.BytesIO(written("dji", plan))) as archive:
        parts = [archive.read(f"wpmz/{name}").decode() for name in ("waylines.wpml", "template.kml")]
    corners = len(score.plan.actions[0])
    assert sum(plan.passed) == len(plan.waypoints) - corners > 5
    for part in parts:
        assert part.count("toPointAndPassWithContinuityCurvature") == sum(plan.passed)
    assert parts[0].count("toPointAndStopWithDiscontinuityCurvature") == corners
    assert parts[1].count("<wpml:useGlobalTurnParam>0<") == sum(plan.passed)
