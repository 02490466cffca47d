"""Plans that are brought forward, and what a mission tells of how early it collects."""

import pytest

from sooner.errors import DataFormatError
from sooner.missions import plan_mission, read_mission
from sooner.planners import region_early
from sooner.planners.region_early import KEEP, brought_forward
from tests.missions.test_over_regions import ground  # noqa: F401  a fixture

MANY = "\n[regions]\nchunk_m = 16.0\n"  # regions, so that there is something to put in order


@pytest.fixture
def by_moves(monkeypatch):
    """As many moves however fast the machine is."""

    def within(problem, plan, seconds, keep=KEEP):
        return brought_forward(problem, plan, keep, walks=2, moves=20_000)

    monkeypatch.setattr(region_early, "brought_forward_within", within)


def test_detection_is_brought_forward_and_information_is_not(ground, by_moves):  # noqa: F811
    late, early = (
        plan_mission(read_mission(ground("belief", "detection", more=more + MANY)), "depth-first", seconds=2.0)
        for more in ("early = false", "")
    )
    assert late.late is None
    assert early.late.total == late.score.evaluation.total
    assert early.score.early_share > late.score.early_share
    assert early.score.evaluation.total >= KEEP * late.score.evaluation.total
    assert early.score.evaluation.mean_time_if_found < late.score.evaluation.mean_time_if_found
    assert plan_mission(read_mission(ground(more=MANY)), "depth-first", seconds=2.0).late is None


def test_information_is_brought_forward_where_it_is_asked_for(ground, by_moves):  # noqa: F811
    planned = plan_mission(read_mission(ground(more="early = true" + MANY, seconds=900)), "depth-first", seconds=2.0)
    told = planned.result(None)
    before = told["brought_forward"]["before"]
    assert told["early_share"] > before["early_share"]
    assert told["value"] == pytest.approx(told["brought_forward"]["kept"] * before["value"])
    assert told["brought_forward"]["kept"] >= KEEP
    assert told["value"] == planned.score.evaluation.value <= told["bound"]


def test_every_plan_over_regions_says_how_early_it_collects(ground):  # noqa: F811
    for known, objective, mean, expected in (
        ("belief", "detection", True, True),
        ("evidence", "detection", True, False),
        ("evidence", "information", False, False),
    ):
        told = plan_mission(read_mission(ground(known, objective)), "greedy", seconds=2.0).result(None)
        assert 0 < told["early_share"] < 1
        assert (told["mean_time_if_found"] is not None) == mean
        assert (told["expected_time"] is not None) == expected
        assert (told["ground_effort"] is not None) == (known == "evidence")


def test_ground_effort_is_told_for_sensors_that_differ_from_place_to_place(ground, tmp_path):  # noqa: F811
    import numpy as np

    path = ground("evidence", "detection")
    path.write_text(path.read_text().replace("detect = 0.85\nfalse_alarm = 0.15", 'glimpse = "see.csv"'))
    see = np.full((24, 40), 0.85)
    np.savetxt(tmp_path / "see.csv", see, delimiter=",")
    same = plan_mission(read_mission(path), "greedy", seconds=2.0).score.effort()
    see[:, 20:] = 0.0
    np.savetxt(tmp_path / "see.csv", see, delimiter=",")
    blind = plan_mission(read_mission(path), "greedy", seconds=2.0).score.effort()
    assert same.before == blind.before
    assert same.after < blind.after < blind.before


@pytest.mark.parametrize(
    ("moves", "more", "told"),
    [
        ("cells", "early = true", "objective.early: an early plan over cells came"),
        ("regions", "early = true\ndetection_target = 0.1", "objective: detection_target and early came"),
    ],
)
def test_an_early_plan_that_means_nothing_is_refused(ground, moves, more, told):  # noqa: F811
    with pytest.raises(DataFormatError, match=told):
        read_mission(ground("belief", "detection", moves, more))
