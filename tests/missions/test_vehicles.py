"""Vehicle files: what they give, that every fault is told at once, and that their page says what is checked."""

import math
import re
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.errors import DataFormatError, InvalidProblemError
from sooner.io.flights.aircraft import DJI_MODELS
from sooner.io.georeference import Georeference
from sooner.missions.vehicle_reference import vehicle_page
from sooner.missions.vehicles import Vehicle, VehicleFile, read_vehicle
from sooner.missions.winds import WindSettings, wind_fault
from sooner.motion import Terrain
from sooner.sensors.camera import Camera

DOCS = Path(__file__).parents[2] / "docs"
SOUND = {
    "speed_mps": 10,
    "accel_mps2": 2,
    "climb_mps": 4,
    "descent_mps": 2,
    "endurance_s": 1500,
    "reserve": 0.2,
}


def written(folder, tail="", **keys):
    """A vehicle file: a sound one with other keys; None leaves one out."""
    said = {key: value for key, value in (SOUND | keys).items() if value is not None}
    path = folder / "vehicle.toml"
    path.write_text("".join(f"{key} = {value!r}\n" for key, value in said.items()) + tail)
    return path


def faults(path):
    with pytest.raises(DataFormatError) as refused:
        read_vehicle(path)
    assert {fault.file for fault in refused.value.faults} == {str(path)}
    return [(fault.key, fault.came, fault.expected) for fault in refused.value.faults]


# ---------------------------------------------------------------- what they give


def test_a_file_becomes_a_vehicle(tmp_path):
    camera = "[camera]\nfov_deg = 60\npixels = 2000\nexposure_s = 0.0005\n"
    vehicle = read_vehicle(written(tmp_path, camera, airspeed_mps=12, swap_s=60, dji="m3e", autopilot="px4"))
    assert vehicle == Vehicle(
        name="vehicle",
        speed_mps=10.0,
        accel_mps2=2.0,
        climb_mps=4.0,
        descent_mps=2.0,
        endurance_s=1500.0,
        reserve_s=300.0,
        airspeed_mps=12.0,
        swap_s=60.0,
        autopilot="px4",
        dji="m3e",
        camera=Camera(math.radians(60), 2000, 0.0005),
    )
    assert vehicle.radius_m(60.0) == pytest.approx(60.0 * math.tan(math.radians(30)))
    assert (vehicle.aircraft.firmware, vehicle.aircraft.model) == (12, DJI_MODELS["m3e"])
    assert read_vehicle(written(tmp_path)).radius_m(60.0) is None
    assert read_vehicle(written(tmp_path, reserve=None, reserve_s=90)).reserve_s == 90.0


@given(altitude=st.floats(0.0, 500.0), below=st.floats(1.0, 20.0), landing=st.floats(0.2, 2.0))
def test_one_battery_is_climb_way_landing_and_reserve(altitude, below, landing):
    slow = Vehicle("slow", 10.0, 2.0, 4.0, 2.0, 1500.0, 300.0, landing_mps=landing, landing_below_m=below)
    parts = slow.climb_s(altitude), slow.flying_s(altitude), slow.landing_s(altitude), slow.reserve_s
    assert sum(parts) == pytest.approx(slow.endurance_s)
    assert slow.climb_s(altitude) >= altitude / slow.climb_mps
    last_m = min(below, altitude)
    assert slow.landing_s(altitude) >= last_m / landing + (altitude - last_m) / slow.descent_mps - 1e-9


def test_what_cannot_climb_and_land_within_its_battery_has_nothing_left():
    assert Vehicle("weak", 10.0, 2.0, 1.0, 1.0, 300.0, 0.0).flying_s(400.0) < 0


def test_pictures_that_would_blur_slow_it_down():
    sharp = Camera(math.radians(60), 2000, 0.001)
    vehicle = Vehicle("seeing", 10.0, 2.0, 4.0, 2.0, 1500.0, 300.0, camera=sharp)
    assert vehicle.cruise_mps(60.0) == pytest.approx(float(sharp.largest_speed(60.0)))
    assert float(sharp.blur(vehicle.cruise_mps(60.0), 60.0)) == pytest.approx(1.0)
    assert vehicle.cruise_mps(1000.0) == 10.0


def test_its_pace_has_all_its_limits():
    vehicle = Vehicle("any", 10.0, 2.0, 4.0, 2.0, 1500.0, 300.0, airspeed_mps=12.0)
    slope = Terrain([[0.0, 20.0, 40.0]], 40.0)
    pace = vehicle.pace(60.0, wind=(-4.0, 0.0), terrain=slope)
    assert (pace.speed_mps, pace.accel_mps2, pace.airspeed_mps, pace.wind) == (10.0, 2.0, 12.0, (-4.0, 0.0))
    assert pace.leg_seconds([[0, 0]], [[80, 0]]) == pytest.approx(80 / 8 + 8 / 2)  # 8 m/s: climb 4 on a slope of 1/2
    assert pace.leg_seconds([[80, 0]], [[0, 0]]) == pytest.approx(80 / 4 + 4 / 2)  # 4 m/s: descent 2


# ---------------------------------------------------------------- faults


def test_an_empty_file_is_told_all_that_it_lacks(tmp_path):
    (tmp_path / "vehicle.toml").write_text("")
    keys = ["speed_mps", "accel_mps2", "climb_mps", "descent_mps", "endurance_s", "reserve"]
    assert [key for key, *_ in faults(tmp_path / "vehicle.toml")] == keys


def test_every_fault_is_told_at_once(tmp_path):
    tail = "[camera]\nfov_deg = 190\npixels = 1.5\nzoom = 3\n"
    path = written(tmp_path, tail, speed_mps=-1, accel_mps2="'fast'", climb_mps=None, dji="m9", wings=2, reserve=1.0)
    told = {key: (came, expected) for key, came, expected in faults(path)}
    assert set(told) == {
        *("speed_mps", "accel_mps2", "climb_mps", "dji", "wings", "reserve"),
        *("camera.fov_deg", "camera.pixels", "camera.zoom"),
    }
    assert told["wings"][0] == "this key is not known"
    assert told["camera.zoom"][1] == "expected one of fov_deg, pixels, exposure_s"
    assert told["reserve"] == ("1.0 came", "expected a number below 1.0")
    assert told["speed_mps"][1] == "expected a number of at least 0.001"


@pytest.mark.parametrize(
    ("keys", "key", "came"),
    [
        ({"airspeed_mps": 9.0}, "airspeed_mps", "9 came, and speed_mps = 10"),
        ({"reserve_s": 60}, "reserve", "0.2 came, and reserve_s = 60"),
        ({"reserve": None, "reserve_s": 1500}, "reserve_s", "1500 came, and endurance_s = 1500"),
        ({"landing_mps": 0.5}, "landing_below_m", "nothing came beside landing_mps"),
        ({"landing_below_m": 5}, "landing_mps", "nothing came beside landing_below_m"),
        ({"landing_mps": 3, "landing_below_m": 5}, "landing_mps", "3 came, and descent_mps = 2"),
        ({"dji": "m3e", "kind": "fixed_wing"}, "dji", "'m3e' came, and kind = 'fixed_wing'"),
        ({"autopilot": "mine"}, "autopilot", "'mine' came"),
        ({"endurance_s": float("inf")}, "endurance_s", "inf came"),
        ({"speed_mps": float("nan")}, "speed_mps", "nan came"),
        ({"name": "red \x1b[31m"}, "name", "'red \\x1b[31m' came"),
    ],
)
def test_what_does_not_go_together_is_refused_with_both(tmp_path, keys, key, came):
    path = written(tmp_path, **{name: value for name, value in keys.items() if name != "name"})
    if "name" in keys:
        path.write_text('name = "red \\u001b[31m"\n' + path.read_text())
    (told,) = faults(path)
    assert told[:2] == (key, came)


def test_a_camera_that_turns_blur_is_refused_and_one_without_a_key(tmp_path):
    blurred = "[camera]\nfov_deg = 60\npixels = 3000\nexposure_s = 0.001\n"
    ((key, came, _),) = faults(written(tmp_path, blurred))
    assert (key, came.partition(" came")[0]) == ("camera", "exposure_s = 0.001")
    assert faults(written(tmp_path, "[camera]\nfov_deg = 60\npixels = 3000\n")) == [
        ("camera.exposure_s", "nothing came", "expected fov_deg, pixels, exposure_s")
    ]


@pytest.mark.parametrize("text", ["speed_mps = ", "\x00", "[" * 100_000])
def test_what_is_no_toml_is_refused(tmp_path, text):
    (tmp_path / "vehicle.toml").write_text(text)
    assert faults(tmp_path / "vehicle.toml")[0][2] == "expected a vehicle file in TOML"


# ---------------------------------------------------------------- wind


@pytest.mark.parametrize(
    ("from_deg", "to"), [(0, (0, -1)), (90, (-1, 0)), (180, (0, 1)), (270, (1, 0)), (360, (0, -1)), (45, None)]
)
def test_a_wind_from_the_north_blows_to_the_south(from_deg, to):
    expected = (-math.sqrt(0.5), -math.sqrt(0.5)) if to is None else to
    blows_to = WindSettings(speed_mps=8.0, from_deg=from_deg).blows_to
    assert blows_to == pytest.approx((8.0 * expected[0], 8.0 * expected[1]), abs=1e-9)


@pytest.mark.parametrize(
    ("crs", "corner", "leans"),
    [
        ("EPSG:32632", (720_000.0, 5_150_000.0), -2.1),
        ("EPSG:3035", (5_100_000.0, 4_800_000.0), -15.1),
        ("EPSG:5070", (-1_450_000.0, 1_950_000.0), 11.0),
        ("EPSG:3857", (1_250_000.0, 5_850_000.0), 0.0),
    ],
)
def test_on_a_map_that_leans_the_wind_comes_from_true_north_still(crs, corner, leans):
    ground = Georeference(crs, corner, 24.0, 24.0)
    east, north = WindSettings(speed_mps=10.0, from_deg=0.0).over(ground, (41, 41))
    assert math.hypot(east, north) == pytest.approx(10.0)
    assert math.degrees(math.atan2(east, -north)) == pytest.approx(-leans, abs=1.0)
    upwind = [[20.0 + 40 * north / 10, 20.0 - 40 * east / 10], [20.0, 20.0]]  # rows go south: 960 m against the wind
    (lat, lon), (middle_lat, middle_lon) = ground.places(upwind)
    assert lat > middle_lat + 0.005
    assert lon == pytest.approx(middle_lon, abs=2e-5)
    turned = WindSettings(speed_mps=10.0, from_deg=90.0).over(ground, (41, 41))
    assert turned == pytest.approx((north, -east))


def test_a_wind_that_a_vehicle_cannot_fly_in_is_refused_with_numbers():
    strong = WindSettings(speed_mps=12.0, from_deg=225.0)
    told = str(wind_fault("ridge.toml", strong, "small.toml", 12.0))
    assert "12 m/s from 225 degrees came, and small.toml flies at most 12 m/s through the air" in told
    unknown = str(wind_fault("ridge.toml", strong, "small.toml", None))
    assert "small.toml does not say how fast it flies through the air; expected airspeed_mps" in unknown
    assert wind_fault("ridge.toml", strong, "small.toml", 12.1) is None
    assert wind_fault("ridge.toml", None, "small.toml", None) is None
    assert wind_fault("ridge.toml", WindSettings(), "small.toml", None) is None
    with pytest.raises(InvalidProblemError, match="a wind of 12 m/s came, and at most 12 m/s"):
        Vehicle("s", 10.0, 2.0, 4.0, 2.0, 1500.0, 300.0, 12.0).pace(60.0, strong.blows_to).flight([[0, 0], [1, 0]])


# ---------------------------------------------------------------- the page and the examples


def test_the_vehicle_file_is_explained_as_it_is_checked():
    told = (DOCS / "vehicle_file.md").read_text(encoding="utf-8")
    assert told == vehicle_page(), "write docs/vehicle_file.md anew from sooner.missions.vehicle_reference"


def test_the_example_of_the_page_is_the_medium_one():
    (text,) = re.findall(r"```toml\n(.*?)```", vehicle_page(), re.DOTALL)
    assert tomllib.loads(text) == tomllib.loads((DOCS / "vehicles" / "medium_copter.toml").read_text())


@pytest.mark.parametrize("path", sorted((DOCS / "vehicles").iterdir()), ids=lambda path: path.stem)
def test_examples_can_be_flown_and_say_that_they_are_examples(path):
    vehicle = read_vehicle(path)
    assert vehicle.name.startswith("Example: ")
    assert "made up" in path.read_text()
    assert vehicle.cruise_mps(60.0) == vehicle.speed_mps
    assert 0.5 * vehicle.endurance_s < vehicle.flying_s(60.0) < vehicle.endurance_s - vehicle.reserve_s
    assert set(tomllib.loads(path.read_text())) <= set(VehicleFile.model_fields)
