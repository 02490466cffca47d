"""Along legs, what a plan finds when it is flown agrees with what the judge promises."""

import numpy as np
import pytest

from sooner.missions.leg_trials import LegFlyover
from sooner.missions.plan_trials import PlanTrials, fly_plan
from tests.missions.leg_missions import leg_mission, there_and_back

TRIALS = 4000
ROUND, FAR = [[200, 900], [800, 900], [800, 100]], [[1400, 900], [1400, 300]]
SENSORS = {
    "whoever is in view is seen": "radius_m = 60.0",
    "a glimpse": "radius_m = 60.0\nglimpse = 0.4",
    "random search": "sweep_width_m = 150\nradius_m = 150.0",
    "the inverse cube": 'sweep_width_m = 150\nlaw = "inverse_cube"',
}


def scored(folder, sensor="", area=""):
    path = leg_mission(folder, 2, 1, area=area)
    path.write_text(path.read_text().replace("radius_m = 60.0", sensor or "radius_m = 60.0"))
    return there_and_back(path, ROUND, FAR)


@pytest.mark.parametrize("sensor", SENSORS)
def test_the_mean_of_flights_is_what_the_judge_promises(tmp_path, sensor):
    score = scored(tmp_path, SENSORS[sensor])
    trials = PlanTrials(score, tuple(fly_plan(score, range(TRIALS))))
    assert 0.1 < score.evaluation.total < 0.9
    assert abs(trials.off) < 4.5
    found = trials.time_if_found
    assert abs(found.value - score.evaluation.mean_time_if_found) < 4.5 * found.error
    assert trials.result()["moves"] == "legs"
    assert trials.result()["time_unit"] == "seconds"


@pytest.mark.parametrize("sensor", SENSORS)
def test_passes_together_miss_as_the_judge_counts(tmp_path, sensor):
    score = scored(tmp_path, SENSORS[sensor])
    flyover = LegFlyover.of(score)
    misses = np.ones(score.mission.problem.grid.n_cells)
    np.multiply.at(misses, flyover.cells, 1.0 - flyover.chances)
    theta = score.mission.sight.theta.ravel()
    assert (theta * (1.0 - misses)).sum() == pytest.approx(score.evaluation.total, rel=1e-6)
    assert (np.diff(flyover.times) >= 0).all()


def test_one_seed_is_one_flight_however_many_workers(tmp_path):
    score = scored(tmp_path, SENSORS["a glimpse"])
    alone = list(fly_plan(score, range(30)))
    assert str(list(fly_plan(score, range(30)))) == str(alone)
    assert str([LegFlyover.of(score).flown(seed) for seed in range(30)]) == str(alone)


def test_who_is_outside_is_not_found(tmp_path):
    from sooner.missions import read_mission, score_plan

    path = leg_mission(tmp_path, 1, 1)
    score = there_and_back(path, ROUND)
    path.write_text(path.read_text().replace("cell_m", "outside = 0.9\ncell_m"))
    elsewhere = score_plan(read_mission(path), score.plan)
    trials = list(fly_plan(elsewhere, range(500)))
    assert sum(trial.there for trial in trials) < 100
    assert not any(trial.found for trial in trials if not trial.there)
