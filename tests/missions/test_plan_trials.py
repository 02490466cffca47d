"""What a plan finds when it is flown agrees with what the judge promises."""

import numpy as np
import pytest

from sooner.io import raster_csv
from sooner.missions import plan_mission, read_mission
from sooner.missions.plan_trials import Flyover, PlanTrial, PlanTrials, fly_plan
from sooner.simulation.hidden import Hidden
from tests.small_mission import small_mission, written

TRIALS = 4000
POC = raster_csv(np.add.outer(np.arange(6), np.arange(7)) ** 2 + 1.0)
THETA = raster_csv(np.linspace(0.02, 0.9, 14 * 20).reshape(14, 20).round(3))
SMALL = small_mission((2, 2), 25)
TWO = SMALL.replace("[budget]", "[[searcher]]\nstart = [5, 6]\nspeed_mps = 12.0\n[budget]")
REGIONS = """
[area]
poc = "theta.csv"
cell_m = 4.0
[sensor]
glimpse = 0.6
radius_m = 6.0
[[searcher]]
start = [1, 1]
moves = "regions"
speed_mps = 5.0
accel_mps2 = 2.0
[budget]
seconds = 90
"""
EVIDENCE = REGIONS.replace("poc =", "evidence =").replace("glimpse = 0.6", "detect = 0.8\nfalse_alarm = 0.1")
INFORMATION = '[objective]\nkind = "information"\n'
OVER_CELLS = """
[area]
evidence = "theta.csv"
[sensor]
detect = 0.8
false_alarm = 0.1
[[searcher]]
start = [1, 1]
[budget]
steps = 60
"""
ALARMS = SMALL.replace("glimpse = 0.5", "detect = 0.6\nfalse_alarm = 0.1")
FLOWN = {
    "a person over cells": SMALL,
    "a person who may be elsewhere": SMALL.replace("cell_m", "outside = 0.4\ncell_m"),
    "looks that correlate": SMALL.replace("glimpse = 0.5", "glimpse = 0.5\ncorrelation = 0.4"),
    "two drones": TWO,
    "a person, in bits": SMALL + INFORMATION,
    "a person, and false alarms": ALARMS,
    "a person and false alarms, in bits": ALARMS + INFORMATION,
    "targets over cells": OVER_CELLS,
    "what there is to learn over cells": OVER_CELLS + INFORMATION,
    "rates over cells": OVER_CELLS.replace("detect = 0.8\nfalse_alarm = 0.1", 'model = "beta"') + INFORMATION,
    "a person over regions": REGIONS,
    "targets over regions": EVIDENCE,
    "what there is to learn over regions": EVIDENCE + INFORMATION,
}


def planned(tmp_path, text, seconds=0.3):
    mission = read_mission(written(tmp_path, text, poc_csv=POC, theta_csv=THETA))
    return plan_mission(mission, seconds=seconds, seed=1).score


@pytest.mark.parametrize("name", FLOWN)
def test_what_is_found_is_what_was_promised(tmp_path, name):
    score = planned(tmp_path, FLOWN[name])
    trials = PlanTrials(score, tuple(fly_plan(score, range(TRIALS))))
    assert abs(trials.off) < 4.0, (trials.value, score.evaluation.total)
    times, promised = trials.time_if_found, score.evaluation.mean_time_if_found
    if score.mission.sight.unit == "probability":
        assert abs(times.value - promised) < 4.0 * times.error + 0.5
    told = trials.result()
    assert told["value"]["promised"] == score.evaluation.total


@pytest.mark.parametrize("text", [SMALL, TWO, REGIONS], ids=["cells", "two drones", "regions"])
def test_cells_are_flown_over_as_often_as_the_judge_counts(tmp_path, text):
    score = planned(tmp_path, text)
    flyover = Flyover.of(score)
    np.testing.assert_array_equal(flyover.counts, score.looks)
    assert (np.diff(flyover.looks.times) >= 0).all()
    assert flyover.looks.times[-1] <= max(searcher.budget for searcher in score.mission.problem.searchers) + 1e-6


def test_false_alarms_come_as_often_as_the_sensor_errs(tmp_path):
    score = planned(tmp_path, OVER_CELLS)
    flyover, trials = Flyover.of(score), PlanTrials(score, tuple(fly_plan(score, range(2000))))
    theta = score.mission.sight.theta.ravel()
    expected = 0.1 * (1.0 - theta[flyover.looks.cells]).sum()
    assert abs(trials.false_alarms.value - expected) < 4.0 * trials.false_alarms.error


SURE = SMALL.replace("glimpse = 0.5", "glimpse = 1.0")


@pytest.mark.parametrize(
    "text",
    [SMALL, SURE + INFORMATION, *(FLOWN[name] for name in ("looks that correlate", "a person who may be elsewhere"))],
    ids=["cells", "bits of sure looks", "correlated", "elsewhere"],
)
def test_a_person_is_found_by_all_looks_as_by_those_at_his_cell(tmp_path, text):
    score = planned(tmp_path, text)
    flyover = Flyover.of(score)
    for seed in range(100):
        hidden = Hidden(score.mission.sight.answers, seed)
        hidden.look(flyover.looks.cells, flyover.looks.times)
        one, other = flyover.flown(seed), PlanTrial.told(seed, score.mission.sight, hidden)
        np.testing.assert_equal(vars(one), vars(other))


def test_a_seed_is_one_flight_whatever_is_flown_beside_it(tmp_path):
    score = planned(tmp_path, OVER_CELLS)
    assert next(fly_plan(score, range(7, 8))) == list(fly_plan(score, range(5, 9)))[2]


@pytest.mark.slow
def test_workers_change_nothing(tmp_path):
    score = planned(tmp_path, OVER_CELLS)
    assert list(fly_plan(score, range(40), workers=2)) == list(fly_plan(score, range(40)))
