"""A mission over waypoints, as it is written and as it is spoiled."""

import json

import numpy as np
import pytest

from sooner.errors import DataFormatError
from sooner.io import StreetMap, street_map_json
from sooner.missions import read_mission
from sooner.missions.over_waypoints import is_over_waypoints, read_street_mission
from sooner.missions.street_trials import StreetTrial, StreetTrials, episode_of, fly_streets, strategy_named
from sooner.scenarios import street_grid
from sooner.simulation import Links

DRONE = """[[searcher]]
moves = "waypoints"
speed_mps = 3.0
accel_mps2 = 2.0
"""
CITY = f"""
[area]
streets = "streets.json"
[target]
count = 2
[sensor]
radius_m = 12.5
{DRONE}
[budget]
seconds = 60
"""
STREETS = street_map_json(StreetMap(street_grid("gridiron", 3, (20, 20))))


@pytest.fixture
def read(tmp_path):
    (tmp_path / "streets.json").write_bytes(STREETS)

    def reading(text, **files):
        for name, content in files.items():
            (tmp_path / name.replace("_", ".")).write_text(content)
        path = tmp_path / "mission.toml"
        path.write_text(text)
        return read_street_mission(path)

    return reading


def test_what_is_left_out_is_as_the_paper_flies_it(read):
    scene = read(CITY).scene
    assert (scene.seconds, scene.replan_s, scene.world.n_targets) == (60, 5, 2)
    assert scene.world.evasive is None
    assert scene.starts_m is None
    (agent,) = scene.agents
    assert (agent.v_max, agent.a_max, agent.radius_m) == (3.0, 2.0, 12.5)
    assert (agent.map_sensor.sensitivity, agent.target_sensor.levels) == (4.0, 25)
    assert scene.estimator.detector == "lrdt"


def test_drones_start_at_coordinates_where_streets_have_theirs(read, tmp_path):
    streets = StreetMap(street_grid("gridiron", 3, (20, 20)), south_west=(46.0, 11.0), scale=2.0)
    (tmp_path / "streets.json").write_bytes(street_map_json(streets))
    beside, above = 7.5 * 10.0, 3.5 * 10.0  # real metres, at the middle of column 7 of the fourth row from the south
    lat = 46.0 + np.degrees(above / 6371008.8)
    lon = 11.0 + np.degrees(beside / 6371008.8 / np.cos(np.radians(46.0)))
    scene = read(CITY.replace("speed", f"start = {{ lat = {lat:.9f}, lon = {lon:.9f} }}\nspeed")).scene
    np.testing.assert_array_equal(scene.starts_m, read(CITY.replace("speed", "start = [16, 7]\nspeed")).scene.starts_m)
    with pytest.raises(DataFormatError, match=r"which is \[42, 7\], came; expected a cell of the map"):
        read(CITY.replace("speed", f"start = {{ lat = 45.998, lon = {lon:.9f} }}\nspeed"))


def test_what_is_said_reaches_the_scene(read):
    text = CITY.replace("count = 2", 'count = 1\nrest = 0.2\nturn_scale = 3.0\nbias = "evasive"\nreach_m = 9.0')
    text = text.replace(
        "[budget]", DRONE + "radius_m = 20.0\ntarget_sensitivity = 2.0\nstart = [0, 3]\n[budget]\nreplan_s = 7"
    )
    text = text.replace('"waypoints"\n', '"waypoints"\nstart = [19, 0]\n', 1)
    scene = read(text + '[estimator]\nprior = "kriged"\nodds = 9.0\n').scene
    assert (scene.world.walk.rest, scene.world.walk.turn_scale, scene.world.evasive.reach_m) == (0.2, 3.0, 9.0)
    assert [agent.radius_m for agent in scene.agents] == [12.5, 20.0]
    assert [agent.target_sensor.sensitivity for agent in scene.agents] == [4.0, 2.0]
    assert (scene.estimator.prior, scene.estimator.odds, scene.replan_s) == ("kriged", 9.0, 7)
    np.testing.assert_allclose(scene.starts_m, [[0.0, 0.0], [15.0, 95.0]])


def test_links_reach_the_scene_and_the_result(read):
    said = "[links]\nrange_m = 40.0\nloss = 0.25\ndelay_s = 2\nrelays = false\n"
    mission = read(CITY.replace("[budget]", DRONE + said + "[budget]"))
    assert mission.scene.links == Links(40.0, 0.25, 2, relays=False)
    trials = StreetTrials(mission, "random", tuple(fly_streets(mission, strategy_named("random")[1], range(2))))
    told = {"range_m": 40.0, "loss": 0.25, "delay_s": 2, "relays": False}
    assert json.loads(json.dumps(trials.result(), allow_nan=False))["links"] == told


def test_links_that_lose_nothing_and_are_prompt_change_nothing(read):
    together = read(CITY.replace("[budget]", DRONE + "[budget]"))
    apart = read(CITY.replace("[budget]", DRONE + "[links]\n[budget]"))
    for name in ("swept_information", "joint"):
        strategy = strategy_named(name)[1]
        assert list(fly_streets(apart, strategy, range(2))) == list(fly_streets(together, strategy, range(2)))


def test_a_glimpse_is_of_every_cell_or_of_each(read):
    assert read(CITY).scene.glimpse is None
    assert (read(CITY.replace("radius_m", "glimpse = 0.25\nradius_m")).scene.glimpse == 0.25).all()
    canopy = np.ones((20, 20))
    canopy[3, 7] = 0.2
    rows = "\n".join(",".join(map(str, row)) for row in canopy)
    scene = read(CITY.replace("radius_m", 'glimpse = "canopy.csv"\nradius_m'), canopy_csv=rows).scene
    assert scene.glimpse.shape == (400,)
    assert np.flatnonzero(scene.glimpse < 1).tolist() == [3 * 20 + 7]


@pytest.mark.parametrize(
    ("rows", "told"), [("1,1\n1,1", "expected 20 x 20 as in streets.json"), ("0.5,2", "1 x 2 cells came")]
)
def test_a_glimpse_of_other_ground_is_refused(read, rows, told):
    with pytest.raises(DataFormatError, match=told) as refused:
        read(CITY.replace("radius_m", 'glimpse = "canopy.csv"\nradius_m'), canopy_csv=rows)
    assert [fault.key for fault in refused.value.faults] == ["sensor.glimpse"]


def test_without_a_target_nobody_is_there(read):
    mission = read(CITY.replace("[target]\ncount = 2\n", ""))
    trials = StreetTrials(mission, "random", tuple(fly_streets(mission, strategy_named("random")[1], range(3))))
    told = trials.result()
    assert told["targets"] == 0
    assert told["e"] == {"mean": None, "standard_error": None, "n": 0}
    assert told["false_detections"]["n"] == 3
    json.dumps(told, allow_nan=False)


def test_a_trial_is_told_as_its_episode_says(read):
    mission = read(CITY)
    _, strategy = strategy_named("lawnmower")
    trials = list(fly_streets(mission, strategy, range(5, 8)))
    assert [trial.seed for trial in trials] == [5, 6, 7]
    assert trials[1] == StreetTrial.of(episode_of(mission, strategy, 6))
    mean = StreetTrials(mission, "lawnmower", tuple(trials)).means()["e"]
    values = [trial.e for trial in trials]
    assert mean.value == pytest.approx(np.mean(values))
    assert mean.error == pytest.approx(np.std(values, ddof=1) / 3**0.5)


@pytest.mark.parametrize(
    ("said", "tracks"),
    [
        ("", "each"),
        ('[estimator]\nprior = "kriged"\n', "each"),
        ('[estimator]\ntracks = "restarted"\n', "restarted"),
        ('[estimator]\ndetector = "cbht"\n', "one"),
    ],
)
def test_several_targets_have_a_track_each_unless_it_is_said_otherwise(read, said, tracks):
    assert read(CITY + said).scene.estimator.tracks == tracks
    assert read(CITY.replace("count = 2", "count = 1")).scene.estimator.tracks == "one"


def test_each_targets_detection_is_told(read):
    mission = read(CITY.replace("count = 2", "count = 3"))
    found = [(4, -1, 9), (20, 30, 10), (-1, -1, -1)]
    trials = [StreetTrial(seed, 0.5, 0.2, 0.3, 0.9, each, 1, 0, 2) for seed, each in enumerate(found)]
    assert [trial.row()[6] for trial in trials] == ["4 - 9", "20 30 10", ""]
    together = StreetTrials(mission, "random", tuple(trials))
    told = json.loads(json.dumps(together.result(), allow_nan=False))
    assert [each["detected"]["mean"] for each in told["by_target"]] == pytest.approx([2 / 3, 1 / 3, 2 / 3])
    assert [each["detected_after_s"]["mean"] for each in told["by_target"]] == pytest.approx([12.0, 30.0, 9.5])
    assert told["all_targets_detected"]["mean"] == pytest.approx(1 / 3)
    assert (told["all_detected_after_s"]["mean"], told["all_detected_after_s"]["n"]) == (30.0, 1)
    assert told["repeated_detections"]["mean"] == 2.0
    assert told["tracks"] == "each"


SPOILED = {
    "tracks where cells are tested": (
        "[budget]",
        '[estimator]\ndetector = "cbht"\ntracks = "each"\n[budget]',
        "estimator",
        "expected 'one'",
    ),
    "no streets": ('streets = "streets.json"', "", "area.streets", "an occupancy graph"),
    "streets that are not there": ("streets.json", "none.json", "area.streets", "none.json"),
    "a poc": ("[target]", 'poc = "poc.csv"\n[target]', "area.poc", "search streets"),
    "a window of a graph": ("[target]", "window = { rows = 3 }\n[target]", "area.window", "has its own"),
    "an unknown part of a window": ("[target]", "window = { row = 3 }\n[target]", "area.window.row", "one of rows"),
    "another cell": ("[target]", "cell_m = 4.0\n[target]", "area.cell_m", "expected 5 m"),
    "a difficulty": ("radius_m", 'difficulty = "d.csv"\nradius_m', "sensor.difficulty", "search streets"),
    "a glimpse of more than all": ("radius_m", "glimpse = 1.5\nradius_m", "sensor.glimpse", "the name of a raster"),
    "a glimpse that is no number": ("radius_m", "glimpse = nan\nradius_m", "sensor.glimpse", "a probability"),
    "a glimpse that is not there": ("radius_m", 'glimpse = "g.csv"\nradius_m', "sensor.glimpse", "g.csv"),
    "no radius": ("radius_m = 12.5", "", "sensor.radius_m", "how far a drone sees"),
    "a radius beyond all": ("radius_m = 12.5", "radius_m = 1e300", "sensor.radius_m", "of at most 1000000"),
    "a radius of nothing": ("radius_m = 12.5", "radius_m = 1e-9", "sensor.radius_m", "of at least 0.001"),
    "a radius within a cell": ("radius_m = 12.5", "radius_m = 2.4", "sensor.radius_m", "at least half a cell, 2.5 m"),
    "its own likewise": ("speed", "radius_m = 2.4\nspeed", "searcher[0].radius_m", "at least half a cell, 2.5 m"),
    "a reach beyond all": ("count = 2", 'bias = "evasive"\nreach_m = 1e300', "target.reach_m", "of at most 1000000"),
    "cells beyond all": ("[target]", "cell_m = 1e300\n[target]", "area.cell_m", "of at most 1000000"),
    "a sensor that cannot be": ("radius_m", "map_sensitivity = 31.0\nradius_m", "sensor.map_sensitivity", "at most 30"),
    "one level": ("radius_m", "levels = 1\nradius_m", "sensor.levels", "at least 2"),
    "no speed": ("speed_mps = 3.0", "", "searcher[0].speed_mps", "metres a second"),
    "too hard a thrust": ("accel_mps2 = 2.0", "accel_mps2 = 200.0", "searcher[0].accel_mps2", "full speed"),
    "a fixed wing": ("speed", 'kind = "fixed_wing"\nspeed', "searcher[0].kind", "it may hover"),
    "an end": ("speed", "end = [0, 0]\nspeed", "searcher[0].end", "search streets"),
    "a start outside": ("speed", "start = [20, 0]\nspeed", "searcher[0].start", "rows 0 to 19"),
    "a start on the globe": ("speed", "start = { lat = 1.0, lon = 1.0 }\nspeed", "searcher[0].start", "on the globe"),
    "half a start": ("speed", "start = { lat = 1.0 }\nspeed", "searcher[0].start.lon", "lat and lon make a place"),
    "a latitude beyond the pole": (
        "speed",
        "start = { lat = 91.0, lon = 1.0 }\nspeed",
        "searcher[0].start",
        "lat from -90",
    ),
    "a start on streets without a place": (
        "speed",
        "start = { lat = 1.0, lon = 1.0 }\nspeed",
        "searcher[0].start",
        "without sw_corner_latlon",
    ),
    "nobody who searches": (DRONE, "", "searcher", "at least one [[searcher]]"),
    "cells over streets": ('moves = "waypoints"\n', "", "searcher[0].moves", "'cells' came; expected 'waypoints'"),
    "unlike moves": ("[budget]", "[[searcher]]\nstart = [0, 0]\n[budget]", "searcher[1].moves", "'waypoints' of all"),
    "some starts": (
        "[budget]",
        DRONE + "start = [0, 0]\n[budget]",
        "searcher[0].start",
        "others start at places of their own",
    ),
    "no seconds": ("seconds = 60", "", "budget.seconds", "whole seconds"),
    "half a second": ("seconds = 60", "seconds = 60.5", "budget.seconds", "whole seconds"),
    "a replan past the end": ("seconds = 60", "seconds = 60\nreplan_s = 61", "budget.replan_s", "at most as many"),
    "steps": ("seconds = 60", "steps = 60", "budget.steps", "search streets"),
    "too many targets": ("count = 2", "count = 999", "target.count", "999 targets"),
    "rest for ever": ("count = 2", "rest = 1.0", "target.rest", "below 1"),
    "boldness without fear": ("count = 2", "boldness = 0.5", "target.boldness", "evasive"),
    "an unknown key of the target": ("count = 2", "speed = 2", "target.speed", "one of count"),
    "an objective": ("[budget]", '[objective]\nkind = "detection"\n[budget]', "objective.kind", "search streets"),
    "links of one drone": ("[budget]", "[links]\nloss = 0.5\n[budget]", "links", "2 to 100 agents"),
    "a delay of half a second": ("[budget]", "[links]\ndelay_s = 0.5\n[budget]", "links.delay_s", "whole number"),
    "cells tested on a known map": (
        "[budget]",
        '[estimator]\ndetector = "cbht"\nprior = "known"\n[budget]',
        "estimator",
        "known map",
    ),
    "odds of nothing": ("[budget]", "[estimator]\nodds = 0.0\n[budget]", "estimator.odds", "above 0"),
}


@pytest.mark.parametrize("name", SPOILED)
def test_a_fault_is_told_by_its_key(read, name):
    right, wrong, key, told = SPOILED[name]
    assert right in CITY
    with pytest.raises(DataFormatError) as refused:
        read(CITY.replace(right, wrong, 1))
    faults = {fault.key: f"{fault.came}; {fault.expected}" for fault in refused.value.faults}
    assert key in faults, faults
    assert told in faults[key]


def test_streets_alone_say_what_is_meant(read, tmp_path):
    with pytest.raises(DataFormatError) as refused:
        read(CITY.replace(DRONE, ""))
    assert [fault.key for fault in refused.value.faults] == ["searcher"]
    assert is_over_waypoints(tmp_path / "mission.toml")
    with pytest.raises(DataFormatError, match=r"area\.streets: streets came, over which nobody plans ahead"):
        read_mission(tmp_path / "mission.toml")


def test_all_faults_come_at_once(read):
    text = CITY.replace("seconds = 60", "steps = 5").replace("radius_m = 12.5", "").replace("count = 2", "count = -1")
    with pytest.raises(DataFormatError) as refused:
        read(text)
    assert {"budget.steps", "budget.seconds", "sensor.radius_m", "target.count"} <= {
        f.key for f in refused.value.faults
    }


def test_streets_that_contradict_themselves_are_told_by_their_file(read):
    with pytest.raises(DataFormatError, match=r"streets\.json|broken\.json"):
        read(CITY.replace("streets.json", "broken.json"), broken_json='{"cell_m": 5.0, "nodes": 3}')


def test_a_mission_that_is_simulated_cannot_be_planned(read, tmp_path):
    read(CITY)
    assert is_over_waypoints(tmp_path / "mission.toml")
    with pytest.raises(DataFormatError, match="sooner simulate"):
        read_mission(tmp_path / "mission.toml")


def test_control_characters_do_not_reach_a_terminal(read, tmp_path):
    with pytest.raises(DataFormatError) as refused:
        read('"\\u001b[31m" = 1\n' + CITY)
    assert "\\x1b[31m: this key is not known" in str(refused.value)
    read(CITY)
    path = (tmp_path / "mission.toml").rename(tmp_path / "a\x1b[31mb.toml")
    assert read_street_mission(path).name == "a\\x1b[31mb"
