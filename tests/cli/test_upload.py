"""`sooner upload`."""

import sys

import pytest

from tests.georeferenced import hills, located, over_cells, rocks
from tests.io.mavlink.scripted_vehicle import ARDUPILOT, HASTE, changed, flying

pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # within rasterio
HOME = "[[searcher]]\nstart = [3, 3]\nend = [3, 3]\nspeed_mps = 12.0\naltitude_m = 80\n"
PLAN = "row,col\n3,3\n3,4\n3,5\n4,5\n4,4\n4,3\n3,3\n"


@pytest.fixture
def ridge(tmp_path):
    (tmp_path / "mine.csv").write_text(PLAN)
    return located(tmp_path, over_cells(HOME), hills())


@pytest.fixture
def hasty(monkeypatch):
    monkeypatch.setattr("sooner.cli.upload._patience", lambda wait: HASTE)


def to(vehicle):
    return "--connect", f"udpout:127.0.0.1:{vehicle.port}"


def test_a_plan_goes_to_a_vehicle(sooner, ridge):
    with flying(autopilot=ARDUPILOT, held={1: 4}) as vehicle:
        ended = sooner("upload", ridge, ridge.parent / "mine.csv", *to(vehicle))
    assert ended.status == 0
    assert "vehicle 1: ArduPilot, disarmed" in ended.err
    assert "note: fence: the vehicle held 4 items of another flight, which were cleared" in ended.err
    assert "Ridge: mission, 9 items sent, 9 held, read back the same" in ended.out
    assert [item.command for item in vehicle.lists[0]] == [16, 22, 178, 16, 16, 16, 16, 16, 20]
    assert [item.z for item in vehicle.lists[0] if item.command == 22] == [80.0]
    assert "MISSION_SET_CURRENT" not in vehicle.heard


def test_json_tells_what_was_sent_and_what_is_held(sooner, ridge, hasty):
    with flying() as vehicle:
        ended = sooner("upload", ridge, ridge.parent / "mine.csv", *to(vehicle), "--json", "--quiet")
    told = ended.json
    assert ended.err == ""
    assert (ended.status, told["mission"], told["same"], told["searcher"]) == (0, "Ridge", True, 0)
    assert told["vehicle"] == {"system": 1, "component": 1, "autopilot": "PX4", "armed": False}
    assert told["lists"] == [{"list": "mission", "sent": 8, "held": 8, "differences": []}]
    assert any("count no time for corners" in note for note in told["notes"])


def test_what_was_stored_otherwise_ends_with_2(sooner, ridge, hasty):
    with flying(keeps=lambda number, item: changed(item, z=item.z + 5.0)) as vehicle:
        ended = sooner("upload", ridge, ridge.parent / "mine.csv", *to(vehicle))
        as_json = sooner("upload", ridge, ridge.parent / "mine.csv", *to(vehicle), "--json")
    assert ended.status == as_json.status == 2
    assert "mission item 0 (take off): altitude 80 was sent, 85 came back" in ended.err
    assert "do not fly it" in ended.err
    assert as_json.json["same"] is False


def test_an_armed_vehicle_is_refused_without_force(sooner, ridge, hasty):
    with flying(armed=True) as vehicle:
        ended = sooner("upload", ridge, ridge.parent / "mine.csv", *to(vehicle))
        assert (ended.status, vehicle.lists[0]) == (2, [])
        assert "vehicle 1: an armed vehicle came; expected one on the ground and disarmed; --force" in ended.err
        assert sooner("upload", ridge, ridge.parent / "mine.csv", *to(vehicle), "--force").status == 0


def test_fences_of_the_mission_go_along(sooner, tmp_path, hasty):
    mission = located(tmp_path, over_cells(HOME, area='obstacles = "rocks.tif"'), hills(), rocks=rocks())
    (tmp_path / "mine.csv").write_text("3,3\n3,2\n3,3\n")
    with flying() as vehicle:
        ended = sooner("upload", mission, tmp_path / "mine.csv", *to(vehicle))
    assert ended.status == 0
    assert {item.command for item in vehicle.lists[1]} == {5001, 5002}
    assert "Ridge: fence, " in ended.out


def test_one_of_several_drones_must_be_named(sooner, tmp_path, hasty):
    mission = located(tmp_path, over_cells(HOME + HOME.replace("80", "95")), hills())
    lines = [f"{drone},{step},3,{3 + step % 2}" for drone in (0, 1) for step in range(3)]
    (tmp_path / "two.csv").write_text("searcher,step,row,col\n" + "\n".join(lines) + "\n")
    with flying() as vehicle:
        ended = sooner("upload", mission, tmp_path / "two.csv", *to(vehicle))
        assert ended.status == 2
        assert "two.csv: flights of drones 0, 1 came; expected --searcher to say which this vehicle flies" in ended.err
        wrong = sooner("upload", mission, tmp_path / "two.csv", *to(vehicle), "--searcher", "2")
        assert (wrong.status, "--searcher: 2 came; expected one of 0, 1" in wrong.err) == (2, True)
        assert vehicle.heard == {}
        told = sooner("upload", mission, tmp_path / "two.csv", *to(vehicle), "--searcher", "1", "--json").json
        assert told["searcher"] == 1
        assert vehicle.lists[0][0].z == 95.0
        assert not any(note.startswith("drone 0") for note in told["notes"])


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--connect", "flight.plan"], "--connect: 'flight.plan' came; expected udp:HOST:PORT"),
        (["--connect", "udp:127.0.0.1:9", "--autopilot", "dji"], "--autopilot: 'dji' came; expected one of ardupilot"),
        (["--connect", "udp:127.0.0.1:9", "--wait", "nan"], "--wait: nan came; expected seconds above 0"),
        (["--connect", "udp:127.0.0.1:9", "--wait", "0"], "--wait: 0 came; expected seconds above 0"),
    ],
)
def test_what_cannot_be_is_refused(sooner, ridge, arguments, told):
    ended = sooner("upload", ridge, ridge.parent / "mine.csv", *arguments)
    assert ended.status == 2
    assert told in ended.err


def test_nobody_is_waited_for_longer_than_asked(sooner, ridge):
    with flying() as vehicle:
        address = to(vehicle)
    ended = sooner("upload", ridge, ridge.parent / "mine.csv", *address, "--wait", "0.2")
    assert ended.status == 2
    assert "no heartbeat came within 0.2 s" in ended.err


def test_a_plan_that_the_mission_does_not_allow_reaches_no_vehicle(sooner, ridge):
    (ridge.parent / "jump.csv").write_text("3,3\n5,5\n3,3\n")
    with flying() as vehicle:
        ended = sooner("upload", ridge, ridge.parent / "jump.csv", *to(vehicle))
    assert (ended.status, vehicle.heard) == (2, {})
    assert "they are not neighbours" in ended.err


def test_a_mission_without_a_place_on_the_globe_reaches_no_vehicle(sooner, mission, tmp_path):
    (tmp_path / "mine.csv").write_text("2,2\n2,3\n")
    with flying() as vehicle:
        ended = sooner("upload", mission, tmp_path / "mine.csv", *to(vehicle))
    assert (ended.status, vehicle.heard) == (2, {})
    assert "area.poc: a raster without a georeference came" in ended.err


def test_it_says_what_to_install(sooner, ridge, monkeypatch):
    monkeypatch.setitem(sys.modules, "pymavlink.dialects.v20", None)
    ended = sooner("upload", ridge, ridge.parent / "mine.csv", "--connect", "udpout:127.0.0.1:9")
    assert ended.status == 2
    assert "pip install 'sooner[aircraft]'" in ended.err
