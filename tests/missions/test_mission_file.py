import re

import numpy as np
import pytest

from sooner.errors import DataFormatError
from sooner.missions import read_mission
from tests.missions.conftest import MISSION, spoiled

ROCK = "0,0,0,0\n0,1,0,0\n0,0,0,0\n"
STEPS = "[budget]\nsteps = 6"
START = "start = [0, 0]"
POC = 'poc = "poc.csv"'

EVIDENCE = MISSION.replace(POC, 'evidence = "theta.csv"').replace("glimpse = 0.5", "detect = 0.85\nfalse_alarm = 0.15")
BETA = MISSION.replace(POC, 'evidence = "theta.csv"').replace("glimpse = 0.5", 'model = "beta"')
BETA += '[objective]\nkind = "information"\n'
REGIONS = """
[area]
evidence = "theta.csv"
cell_m = 4.0
[sensor]
detect = 0.85
false_alarm = 0.15
radius_m = 6.0
[[searcher]]
start = [0, 0]
moves = "regions"
speed_mps = 5.0
accel_mps2 = 2.0
[budget]
seconds = 200
"""
CAMERA = "camera = { fov_deg = 90, altitude_m = 9, pixels = 1200, exposure_s = 0.001 }"

BAD = {
    "not TOML": ("[area\n", "", "not TOML"),
    "unknown table": (MISSION + "[extra]\n", "extra", "expected one of name, area"),
    "unknown key in brackets": ('"x[1]" = 1\n' + MISSION, "x[1]", "expected one of name"),
    "unknown key": (spoiled(POC, POC + "\ncolour = 3"), "area.colour", "expected one of poc, outside"),
    "a table that is a number": (
        spoiled("[sensor]\nglimpse = 0.5", "").replace("name", "sensor = 3\nname"),
        "sensor",
        "3 came",
    ),
    "no raster": (spoiled(POC, ""), "area.poc", "nothing came"),
    "raster of a number": (spoiled(POC, "poc = 3"), "area.poc", "expected text in quotes"),
    "missing raster": (spoiled(POC, 'poc = "none.csv"'), "area.poc", "there is no such file"),
    "raster that is a folder": (spoiled(POC, 'poc = ".csv/../."'), "area.poc", "suffix"),
    "unknown suffix": (spoiled(POC, 'poc = "mission.toml"'), "area.poc", "'.toml' came"),
    "outside of one": (spoiled(POC, POC + "\noutside = 1.0"), "area.outside", "below 1"),
    "negative outside": (spoiled(POC, POC + "\noutside = -0.1"), "area.outside", "at least 0"),
    "cell size of zero": (spoiled("cell_m = 24.0", "cell_m = 0"), "area.cell_m", "at least 0.001"),
    "unknown grid": (spoiled(POC, POC + '\ngrid = "round"'), "area.grid", "'hex'"),
    "no searcher": (spoiled(f"[[searcher]]\n{START}\nspeed_mps = 12.0", ""), "searcher", "at least one"),
    "searcher as one table": (spoiled("[[searcher]]", "[searcher]"), "searcher", "[[searcher]]"),
    "no start": (spoiled(START, ""), "searcher[0].start", "nothing came"),
    "start of three numbers": (spoiled(START, "start = [0, 0, 0]"), "searcher[0].start", "[0, 0, 0] came"),
    "start between cells": (spoiled(START, "start = [0.5, 0]"), "searcher[0].start", "whole numbers"),
    "start of words": (spoiled(START, 'start = "here"'), "searcher[0].start", "'here' came"),
    "start off the map": (spoiled(START, "start = [3, 0]"), "searcher[0].start", "rows 0 to 2"),
    "start at a negative row": (spoiled(START, "start = [-1, 0]"), "searcher[0].start", "rows 0 to 2"),
    "end off the map": (spoiled(START, START + "\nend = [0, 4]"), "searcher[0].end", "columns 0 to 3"),
    "end too far": (
        spoiled(START, START + "\nend = [2, 3]").replace("steps = 6", "steps = 4"),
        "searcher[0].end",
        "lies 5 steps",
    ),
    "end of the wrong parity": (
        spoiled(START, START + '\nend = [0, 1]\nkind = "fixed_wing"'),
        "searcher[0].end",
        "cannot hover",
    ),
    "unknown kind": (spoiled(START, START + '\nkind = "glider"'), "searcher[0].kind", "'copter' or 'fixed_wing'"),
    "speed of zero": (spoiled("speed_mps = 12.0", "speed_mps = 0"), "searcher[0].speed_mps", "at least 0.001"),
    "speed of infinity": (spoiled("speed_mps = 12.0", "speed_mps = inf"), "searcher[0].speed_mps", "finite"),
    "no budget": (spoiled(STEPS, ""), "budget", "nothing came"),
    "two budgets": (spoiled(STEPS, STEPS + "\nseconds = 9"), "budget", "expected one of them"),
    "no steps": (spoiled("steps = 6", "steps = 0"), "budget.steps", "at least 1"),
    "negative steps": (spoiled("steps = 6", "steps = -3"), "budget.steps", "at least 1"),
    "more steps than anyone flies": (spoiled("steps = 6", "steps = 10000000000"), "budget.steps", "at most 200000"),
    "more seconds than anyone flies": (spoiled("steps = 6", "seconds = 1e9"), "budget.seconds", "at most 200,000"),
    "faster than anything": (spoiled("speed_mps = 12.0", "speed_mps = 1e308"), "searcher[0].speed_mps", "at most"),
    "half a step": (spoiled("steps = 6", "steps = 6.5"), "budget.steps", "whole number"),
    "steps as text": (spoiled("steps = 6", 'steps = "6"'), "budget.steps", "whole number"),
    "seconds too few for a step": (spoiled("steps = 6", "seconds = 1"), "budget.seconds", "at least one step"),
    "seconds without speed": (
        spoiled("steps = 6", "seconds = 60").replace("speed_mps = 12.0", ""),
        "searcher[0].speed_mps",
        "nothing came",
    ),
    "seconds without cell size": (
        spoiled("steps = 6", "seconds = 60").replace("cell_m = 24.0", ""),
        "area.cell_m",
        "nothing came",
    ),
    "glimpse above one": (spoiled("glimpse = 0.5", "glimpse = 1.5"), "sensor.glimpse", "[0, 1]"),
    "glimpse of NaN": (spoiled("glimpse = 0.5", "glimpse = nan"), "sensor.glimpse", "nan came"),
    "two sensors": (spoiled("glimpse = 0.5", 'glimpse = 0.5\ndifficulty = "poc.csv"'), "sensor", "one of them"),
    "correlation above one": (spoiled("glimpse = 0.5", "correlation = 2"), "sensor.correlation", "at most 1"),
    "target above one": (MISSION + "[objective]\ndetection_target = 2\n", "objective.detection_target", "at most 1"),
    "evidence that is no probability": (spoiled(POC, 'evidence = "poc.csv"'), "area.evidence", "numbers in [0, 1]"),
    "evidence beside weights": (spoiled(POC, POC + '\nevidence = "theta.csv"'), "area", "poc and evidence came"),
    "evidence with something outside": (
        EVIDENCE.replace("cell_m", "outside = 0.1\ncell_m"),
        "area.outside",
        "left out",
    ),
    "a target over evidence": (EVIDENCE + "[objective]\ndetection_target = 0.5\n", "objective.detection_target", "poc"),
    "false alarms without hits": (EVIDENCE.replace("detect = 0.85", ""), "sensor.detect", "nothing came"),
    "false alarms of looks that correlate": (
        spoiled("glimpse = 0.5", "detect = 0.9\nfalse_alarm = 0.1\ncorrelation = 0.5"),
        "sensor.correlation",
        "each look by itself",
    ),
    "no more hits than false alarms": (
        EVIDENCE.replace("false_alarm = 0.15", "false_alarm = 0.85"),
        "sensor.detect",
        "0.85 came, and false_alarm = 0.85; expected more than false_alarm",
    ),
    "hits above one": (EVIDENCE.replace("detect = 0.85", "detect = 1.5"), "sensor.detect", "at most 1"),
    "false alarms below zero": (EVIDENCE.replace("= 0.15", "= -0.1"), "sensor.false_alarm", "at least 0"),
    "hits and glimpse": (EVIDENCE.replace("detect", "glimpse = 0.5\ndetect"), "sensor", "glimpse and detect came"),
    "correlated information": (
        MISSION.replace("glimpse = 0.5", "glimpse = 0.5\ncorrelation = 0.5") + '[objective]\nkind = "information"\n',
        "sensor.correlation",
        "left out",
    ),
    "a target in bits": (
        MISSION + '[objective]\nkind = "information"\ndetection_target = 0.5\n',
        "objective.detection_target",
        'kind = "detection"',
    ),
    "beta of weights": (
        MISSION.replace("glimpse = 0.5", 'model = "beta"') + '[objective]\nkind = "information"\n',
        "sensor.model",
        "without area.evidence",
    ),
    "a beta law that is certain": (BETA.replace("theta.csv", "certain.csv"), "area.evidence", "above 0 and below 1"),
    "beta for detection": (BETA.replace('"information"', '"detection"'), "objective.kind", "a yes is no find"),
    "beta with hits": (BETA.replace("model", "detect = 0.9\nmodel"), "sensor.detect", "expected it left out"),
    "obstacles everywhere": (spoiled(POC, POC + '\nobstacles = "poc.csv"'), "area.obstacles", "in every cell"),
    "regions that are not flown": (MISSION + "[regions]\n", "regions", 'searcher.moves = "regions"'),
    "later: radius": (spoiled("glimpse = 0.5", "radius_m = 8"), "sensor.radius_m", "does not do yet"),
    "later: acceleration": (spoiled(START, START + "\naccel_mps2 = 2"), "searcher[0].accel_mps2", "does not do yet"),
    "waypoints": (spoiled(START, START + '\nmoves = "waypoints"'), "searcher[0].moves", "which nobody plans ahead"),
    "streets over cells": (
        spoiled(POC, POC + '\nstreets = "s.json"'),
        "area.streets",
        "`sooner simulate` flies over unknown streets",
    ),
    "a target over cells": (MISSION + "[target]\ncount = 1\n", "target", 'searcher.moves = "waypoints"'),
    "an unknown key of links": (
        MISSION + "[links]\nrange = 1\n[[searcher]]\nstart = [0, 0]\nspeed_mps = 12.0\n",
        "links.range",
        "expected one of range_m",
    ),
    "later: unlike moves": (
        REGIONS.replace("[budget]", "[[searcher]]\nstart = [1, 1]\nspeed_mps = 5.0\naccel_mps2 = 2.0\n[budget]"),
        "searcher[1].moves",
        "'cells' beside 'regions'",
    ),
    "later: a fixed wing over regions": (
        REGIONS.replace("accel", 'kind = "fixed_wing"\naccel'),
        "searcher[0].kind",
        "does not do yet",
    ),
    "regions of hexagons": (REGIONS.replace("cell_m", 'grid = "hex"\ncell_m'), "area.grid", "square cells"),
    "regions in steps": (REGIONS.replace("seconds = 200", "steps = 200"), "budget.steps", "expected budget.seconds"),
    "regions without metres": (REGIONS.replace("cell_m = 4.0", ""), "area.cell_m", "nothing came"),
    "regions without speed": (REGIONS.replace("speed_mps = 5.0", ""), "searcher[0].speed_mps", "nothing came"),
    "regions without acceleration": (REGIONS.replace("accel_mps2 = 2.0", ""), "searcher[0].accel_mps2", "nothing came"),
    "regions without radius": (REGIONS.replace("radius_m = 6.0", ""), "sensor.radius_m", "or a camera"),
    "a radius below half a cell": (
        REGIONS.replace("radius_m = 6.0", "radius_m = 1.9"),
        "sensor.radius_m",
        "at least half a cell, 2 m",
    ),
    "a radius beyond all": (
        REGIONS.replace("radius_m = 6.0", "radius_m = 1e300"),
        "sensor.radius_m",
        "at most 1000000",
    ),
    "a camera that sees beyond all": (
        REGIONS.replace("radius_m = 6.0", CAMERA.replace("fov_deg = 90", "fov_deg = 179.9999999")),
        "sensor.camera",
        "a narrower view",
    ),
    "radius and camera": (REGIONS.replace("radius_m", f"{CAMERA}\nradius_m"), "sensor", "radius_m and camera came"),
    "half a camera": (
        REGIONS.replace("radius_m = 6.0", "camera = { fov_deg = 90, altitude_m = 9, pixels = 1200 }"),
        "sensor.camera.exposure_s",
        "nothing came",
    ),
    "an unknown part of a camera": (
        REGIONS.replace("radius_m = 6.0", CAMERA.replace("pixels", "zoom = 2, pixels")),
        "sensor.camera.zoom",
        "expected one of fov_deg, altitude_m",
    ),
    "a camera that blurs standing still": (
        REGIONS.replace("radius_m = 6.0", CAMERA.replace("0.001", "0.1")),
        "sensor.camera",
        "turns of the drone alone blur the picture",
    ),
    "lines that leave gaps": (REGIONS + "[regions]\nspacing_m = 12.5\n", "regions.spacing_m", "at most twice as much"),
    "chunks of plain regions": (
        REGIONS + '[regions]\ncut = "plain"\nchunk_m = 9\n',
        "regions.chunk_m",
        'cut = "aware"',
    ),
    "no time for any search": (
        REGIONS.replace("seconds = 200", "seconds = 2"),
        "budget.seconds",
        "a budget of 2 s came; the quickest action",
    ),
    "an end beyond the rocks": (
        REGIONS.replace("start", "end = [0, 3]\nstart").replace("[sensor]", 'obstacles = "wall.csv"\n[sensor]'),
        "searcher[0].end",
        "obstacles lie all around one",
    ),
    "later: searchers of different speeds": (
        MISSION + "[[searcher]]\nstart = [1, 1]\nspeed_mps = 6.0\n",
        "searcher[1].speed_mps",
        "does not do yet",
    ),
    "later: a target for several": (
        MISSION + "[[searcher]]\nstart = [1, 1]\nspeed_mps = 12.0\n[objective]\ndetection_target = 0.5\n",
        "objective.detection_target",
        "does not do yet",
    ),
    "a latitude beyond the pole": (
        spoiled(START, "start = {lat = 96.1, lon = 11.2}"),
        "searcher[0].start",
        "expected lat from -90 to 90, lon from -180 to 180",
    ),
    "a name that colours a terminal": (
        re.sub("name = .*", lambda _: r'name = "\u001b[31mred"', MISSION, count=1),
        "name",
        "expected text in one line, without control characters",
    ),
    "a latitude on a map without a place": (
        spoiled(START, "start = {lat = 46.1, lon = 11.2}"),
        "searcher[0].start",
        "a map without a georeference",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_a_fault_names_file_key_and_what_was_expected(mission, name):
    text, key, told = BAD[name]
    path = mission(text)
    with pytest.raises(DataFormatError) as raised:
        read_mission(path)
    assert [(fault.file, fault.key) for fault in raised.value.faults] == [(str(path), key)]
    assert told in str(raised.value)


RASTERS = {
    "NaN": ("1,nan\n3,4\n", "nan at [0, 1]"),
    "infinite": ("1,inf\n3,4\n", "inf at [0, 1]"),
    "negative": ("1,2\n3,-4\n", "-4 at [1, 1]"),
    "all zero": ("0,0\n0,0\n", "every weight is zero"),
    "ragged": ("1,2\n3\n", "line 2: 1 values came; expected 2"),
    "words": ("1,2\n3,four\n", "line 2, value 2: 'four' came"),
    "empty": ("", "an empty file"),
    "blank": ("\n \n", "an empty file"),
    "binary": (bytes(range(256)), "not text"),
}


@pytest.mark.parametrize("name", RASTERS)
def test_a_bad_raster_is_a_fault_of_the_key_that_names_it(mission, name):
    content, told = RASTERS[name]
    path = mission(poc_csv=content)
    with pytest.raises(DataFormatError) as raised:
        read_mission(path)
    assert [(fault.file, fault.key) for fault in raised.value.faults] == [(str(path), "area.poc")]
    assert told in str(raised.value)


@pytest.mark.parametrize(("key", "table"), [("difficulty", "sensor"), ("glimpse", "sensor"), ("obstacles", "area")])
def test_a_layer_of_another_shape_is_refused(mission, key, table):
    text = MISSION.replace("glimpse = 0.5", "").replace(f"[{table}]", f'[{table}]\n{key} = "layer.csv"')
    path = mission(text, layer_csv="0,0\n0,0\n")
    with pytest.raises(
        DataFormatError, match=r"2 x 2 cells came in layer\.csv; expected 3 x 4 as in poc\.csv"
    ) as raised:
        read_mission(path)
    assert [fault.key for fault in raised.value.faults] == [f"{table}.{key}"]


@pytest.mark.parametrize("which", ["start", "end"])
def test_a_start_or_end_on_an_obstacle_is_refused(mission, which):
    searcher = "start = [1, 1]" if which == "start" else "start = [0, 0]\nend = [1, 1]"
    path = mission(spoiled(POC, POC + '\nobstacles = "rock.csv"').replace(START, searcher), rock_csv=ROCK)
    with pytest.raises(DataFormatError, match="an obstacle stands there") as raised:
        read_mission(path)
    assert [fault.key for fault in raised.value.faults] == [f"searcher[0].{which}"]


def test_every_fault_of_a_file_and_of_its_rasters_is_reported_at_once(mission):
    text = """
    nme = "x"
    [area]
    poc = "poc.csv"
    outside = 2
    obstacles = "none.csv"
    [sensor]
    difficulty = "layer.csv"
    [[searcher]]
    start = [9, 9]
    end = [1.5, 2]
    [[searcher]]
    kind = "glider"
    [budget]
    steps = 0
    [objective]
    kind = "informative"
    """
    with pytest.raises(DataFormatError) as raised:
        read_mission(mission(text, layer_csv="1,2,3,4\n1,2\nx,2,3,-4\n"))
    keys = [fault.key for fault in raised.value.faults]
    told = """nme area.outside area.obstacles sensor.difficulty sensor.difficulty searcher[0].start searcher[0].end
    searcher[1].start searcher[1].kind budget.steps objective.kind"""
    assert sorted(keys) == sorted(told.split())


def test_a_missing_mission_file_is_a_fault(tmp_path):
    with pytest.raises(DataFormatError, match="no such file"):
        read_mission(tmp_path / "none.toml")
    with pytest.raises(DataFormatError, match="a folder came"):
        read_mission(tmp_path)


def test_a_mission_becomes_the_problem_it_describes(mission):
    read = read_mission(mission())
    assert read.problem.grid.shape == (3, 4)
    assert read.problem.searcher.budget == 6
    assert read.step_s == 2.0
    np.testing.assert_allclose(read.problem.gains.first, np.ravel([[1, 2, 3, 4], [5, 6, 7, 8], [9, 8, 7, 6]]) / 66 / 2)


def test_seconds_become_the_steps_that_fit(mission):
    assert read_mission(mission(spoiled("steps = 6", "seconds = 13.9"))).problem.searcher.budget == 6


def test_diagonal_steps_never_take_longer_than_they_say(mission):
    square8 = spoiled("steps = 6", "seconds = 30").replace(POC, POC + '\ngrid = "square8"')
    assert read_mission(mission(square8)).problem.searcher.budget == int(30 / (24 * 2**0.5 / 12))


def test_difficulty_becomes_glimpse_as_in_the_paper(mission):
    text = spoiled("glimpse = 0.5", 'difficulty = "layer.csv"')
    read = read_mission(mission(text, layer_csv="0,1,2,3\n0,0,0,0\n0,0,0,0\n"))
    np.testing.assert_array_equal(read.glimpse[0], [1.0, 0.75, 0.5, 0.25])


def test_without_a_sensor_every_look_detects_and_a_note_says_so(mission):
    read = read_mission(mission(spoiled("[sensor]\nglimpse = 0.5", "")))
    assert (read.glimpse == 1.0).all()
    assert any("every look" in note for note in read.notes)


def test_outside_lowers_every_cell(mission):
    read = read_mission(mission(spoiled(POC, POC + "\noutside = 0.5")))
    assert read.belief.poc.sum() == pytest.approx(0.5)


def test_correlated_looks_pay_less_the_second_time(mission):
    read = read_mission(mission(spoiled("glimpse = 0.5", "glimpse = 0.5\ncorrelation = 1.0")))
    assert read.problem.gains.of(np.array([0]), np.array([1]))[0] == 0.0


def test_like_faults_are_told_ten_times_and_counted_and_no_other_is_lost(mission):
    text = MISSION + "\n".join('[[searcher]]\nstart = [99, 0]\nspeed_mps = "fast"' for _ in range(1000))
    with pytest.raises(DataFormatError) as refused:
        read_mission(mission(text.replace(STEPS, "[budget]\nsteps = -1")))
    told = [str(fault) for fault in refused.value.faults]
    assert len(told) < 40
    assert sum("'fast' came" in line for line in told) == 10
    assert sum("searcher[...].speed_mps: 990 more faults like these" in line for line in told) == 1
    assert sum("budget.steps" in line for line in told) == 1
