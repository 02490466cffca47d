"""Maps of a plan are the judge's own numbers, cell by cell."""

import numpy as np
import pytest

from sooner.errors import UnsupportedProblemError
from sooner.missions import read_mission
from sooner.missions.chances import LAYERS, chances
from sooner.sensors import miss_after_looks
from tests.georeferenced import greedily, hills, located, over_cells, over_regions

HOME = "[[searcher]]\nstart = [3, 3]\nspeed_mps = 12.0\n"


def planned(tmp_path, text, **rasters):
    return greedily(read_mission(located(tmp_path, text, 0.9 * hills(), **rasters)))


@pytest.mark.parametrize("sensor", ["glimpse = 0.6", 'difficulty = "hard.tif"', "glimpse = 1.0", "glimpse = 0.0"])
def test_before_times_pod_is_found_and_the_rest_remains(tmp_path, sensor):
    score = planned(tmp_path, over_cells(HOME, 60, "outside = 0.2", sensor), hard=np.arange(192.0).reshape(12, 16) % 3)
    found = chances(score)
    assert list(found) == list(LAYERS)
    assert all(values.shape == (12, 16) for values in found.values())
    np.testing.assert_allclose(found["poc-before"].sum(), 0.8)
    np.testing.assert_allclose((found["poc-before"] * found["pod"]).sum(), score.evaluation.total, atol=1e-9)
    np.testing.assert_allclose(found["poc-after"].ravel(), score.left, atol=1e-9)
    expected = 1.0 - (1.0 - score.mission.glimpse.ravel()) ** score.looks
    np.testing.assert_allclose(found["pod"].ravel(), expected, atol=1e-9)


def test_looks_that_resemble_each_other_find_less(tmp_path):
    text = over_cells(HOME, 60, sensor="glimpse = 0.6\ncorrelation = 0.5")
    score = planned(tmp_path, text)
    found = chances(score)
    np.testing.assert_allclose((found["poc-before"] * found["pod"]).sum(), score.evaluation.total, atol=1e-9)
    few = score.looks <= 16
    expected = 1.0 - miss_after_looks(np.full(few.sum(), 0.6), 16, 0.5)[np.arange(few.sum()), score.looks[few]]
    np.testing.assert_allclose(found["pod"].ravel()[few], expected, atol=1e-9)


def test_over_regions_cells_count_as_often_as_they_come_into_view(tmp_path):
    score = planned(tmp_path, over_regions("start = [3, 3]\n"))
    found = chances(score)
    np.testing.assert_allclose(found["poc-before"].ravel(), np.ravel(score.mission.sight.theta))
    np.testing.assert_allclose(found["pod"].ravel(), 1.0 - 0.15**score.looks, atol=1e-9)


def test_where_targets_come_and_go_nobody_is_found(tmp_path):
    sensor = "detect = 0.85\nfalse_alarm = 0.15"
    text = over_regions("start = [3, 3]\n").replace(sensor, 'model = "beta"')
    mission = read_mission(located(tmp_path, text, np.full((12, 16), 0.4)))
    with pytest.raises(UnsupportedProblemError, match="geotiff expects looks that detect"):
        chances(greedily(mission))
