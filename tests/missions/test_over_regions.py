"""Missions over regions, from the file to the plan, and information over cells."""

from dataclasses import replace

import numpy as np
import pytest

from sooner.errors import DataFormatError, UnsupportedProblemError
from sooner.missions import plan_mission, read_mission, score_plan
from sooner.missions.planning import plan_file, read_plan_file
from sooner.missions.sight import Sight
from sooner.motion.kinematics import Dynamics
from sooner.motion.rounded import rounded
from sooner.motion.trajectory import Trajectory, integrated
from sooner.planners import Solution, max_ticks, solve
from sooner.planners.registry import PLANNERS, make_planner

HEIGHT, WIDTH = 24, 40
REGIONS = """
name = "Ground"
[area]
AREA
cell_m = 4.0
obstacles = "rock.csv"
[sensor]
SENSOR
[[searcher]]
start = [2, 2]
end = [2, 2]
speed_mps = 5.0
MOVES
[budget]
seconds = 240
[objective]
kind = "OBJECTIVE"
MORE
"""
OVER = {"cells": "", "regions": 'moves = "regions"\naccel_mps2 = 2.0'}
KNOWN = {
    "belief": ('poc = "poc.csv"', "glimpse = 0.6"),
    "evidence": ('evidence = "theta.csv"', "detect = 0.85\nfalse_alarm = 0.15"),
    "beta": ('evidence = "theta.csv"', 'model = "beta"'),
}


@pytest.fixture
def ground(tmp_path):
    """ground(known, objective, moves, more, radius) -> a mission on ground with a rock in it."""
    rows, cols = np.mgrid[0:HEIGHT, 0:WIDTH]
    rock = np.zeros((HEIGHT, WIDTH), int)
    rock[8:16, 14:26] = 1
    theta = np.where(cols < 20, 0.5, 0.9 - 0.01 * rows)
    for name, values in {"rock": rock, "theta": theta, "poc": theta**3 * (1 - rock)}.items():
        np.savetxt(tmp_path / f"{name}.csv", values, delimiter=",", fmt="%.4f")

    def write(
        known="evidence", objective="information", moves="regions", more="", radius="radius_m = 8.0", seconds=240
    ):
        area, sensor = KNOWN[known]
        if moves == "regions":
            sensor += "\n" + radius
        text = REGIONS.replace("AREA", area).replace("SENSOR", sensor).replace("MOVES", OVER[moves])
        path = tmp_path / "mission.toml"
        path.write_text(text.replace("OBJECTIVE", objective).replace("= 240", f"= {seconds}").replace("MORE", more))
        return path

    return write


PLAIN = '[regions]\ncut = "plain"\nspacing_m = 8.0'

KINDS = [
    (known, objective, moves)
    for known in KNOWN
    for objective in ("detection", "information")
    for moves in OVER
    if (known, objective) != ("beta", "detection")
]


@pytest.mark.parametrize(("known", "objective", "moves"), KINDS)
def test_both_objectives_are_planned_over_both_moves_and_proved(ground, known, objective, moves):
    mission = read_mission(ground(known, objective, moves))
    planned = plan_mission(mission, "greedy", seconds=5.0)
    best, score = planned.solution.best, planned.score
    assert 0 < best.value <= best.bound < np.inf
    assert best.bound_proof
    assert score.evaluation.value == best.value
    assert score.seconds <= 240.0 + 1e-6
    assert planned.result(None)["unit"] == {"information": "bits"}.get(
        objective, "probability" if known == "belief" else "targets"
    )


@pytest.mark.parametrize(("known", "objective", "moves"), KINDS)
def test_looks_counted_cell_by_cell_are_worth_what_the_judge_says(ground, known, objective, moves):
    mission = read_mission(ground(known, objective, moves))
    score = score_plan(mission, solve(mission.problem, make_planner("greedy")).best.plan)
    worth = mission.sight.worth(score.looks)
    assert worth.sum() == pytest.approx(score.evaluation.total, rel=1e-9)
    there = np.ravel(mission.sight.there)
    np.testing.assert_allclose(score.left, np.maximum(there - worth, 0.0))
    assert (worth <= there + 1e-9).all()


@pytest.mark.parametrize("turns", ["stop", "rounded"])
def test_a_plan_lasts_as_long_as_its_flight_integrated_in_small_steps(ground, turns):
    mission = read_mission(ground(more=f'[regions]\nturns = "{turns}"\nspacing_m = 8.0'))
    moves, drone = mission.problem.searcher.moves, Dynamics(5.0, 2.0)
    plan = plan_mission(mission, "depth-first", seconds=5.0).score.plan
    total = 0.0
    for action, _, turned in moves.flown(plan.actions[0]):
        path = moves.graph.paths[action][:: -1 if turned else 1]
        flight = (
            rounded(path, drone, deviation_m=2.0)
            if turns == "rounded" and len(path) > 2
            else Trajectory.through(path, drone)
        )
        flown = integrated(flight, dt=0.01)
        assert max(flown.end_m, flown.end_mps) < 1e-3 * max(flight.length_m, 1.0)
        assert flown.top_mps < 5.0 + 1e-3
        assert flown.top_mps2 < 2.0 + 1e-3
        total += flight.duration
    assert score_plan(mission, plan).seconds == pytest.approx(total, abs=1e-3)


@pytest.mark.parametrize("known", ["belief", "evidence"])
def test_a_plan_file_over_regions_is_read_back(ground, tmp_path, known):
    mission = read_mission(ground(known, "detection"))
    plan = plan_mission(mission, "greedy", seconds=5.0).score.plan
    (tmp_path / "plan.csv").write_bytes(plan_file(mission, plan))
    assert read_plan_file(mission, tmp_path / "plan.csv") == plan


def test_the_probability_of_finding_the_person_is_told_where_information_is_the_objective(ground):
    plans = {}
    for objective in ("information", "detection"):
        mission = read_mission(ground("belief", objective))
        plans[objective] = mission
    plan = plan_mission(plans["information"], "greedy", seconds=5.0).score.plan
    found = score_plan(plans["information"], plan).found
    assert found == pytest.approx(score_plan(plans["detection"], plan).evaluation.total)


def test_a_flight_spares_people_on_the_ground_time(ground):
    score = plan_mission(read_mission(ground()), "greedy", seconds=5.0).score
    for variant in ("corrected", "printed"):
        effort = score.effort(variant)
        assert 0 < effort.after < effort.before
    assert score.effort().after > score.effort("printed").after
    assert plan_mission(read_mission(ground("belief")), "greedy", seconds=5.0).score.effort() is None


def test_the_reference_is_named_beside_the_bound(ground):
    told = plan_mission(read_mission(ground()), "greedy", seconds=5.0).result(None)
    assert told["reference_name"] == "iterative greedy"
    assert told["efficiency"] == pytest.approx(told["value"] / told["reference"])
    assert told["bound_proof"] == "linear program over regions"


def test_two_drones_learn_more_than_one_and_less_than_their_joint_bound(ground):
    path = ground()
    one = plan_mission(read_mission(path), "greedy", seconds=5.0).solution.best
    searcher = path.read_text().partition("[[searcher]]")[2].partition("[budget]")[0]
    path.write_text(path.read_text().replace("[budget]", f"[[searcher]]{searcher}[budget]"))
    mission = read_mission(path)
    two: Solution = plan_mission(mission, "greedy", seconds=5.0).solution
    assert one.value < two.best.value <= two.best.bound
    assert len(two.best.plan.actions) == 2


def test_a_camera_sets_the_radius_and_caps_the_speed(ground):
    camera = "camera = { fov_deg = 90, altitude_m = 8, pixels = 1200, exposure_s = 0.003 }"
    slow, fast = (
        read_mission(ground(radius=radius, seconds=3000, more=PLAIN)) for radius in (camera, "radius_m = 8.0")
    )
    sharp = 8.0 * (2.0 / (0.003 * 1200) - 0.5)
    assert sharp < 5.0
    assert slow.notes == (f"[sensor.camera] allows {sharp:.3g} m/s; nothing flies faster",)
    assert not fast.notes
    assert (slow.problem.searcher.moves.graph.seconds > fast.problem.searcher.moves.graph.seconds).all()


def test_a_short_view_ahead_caps_the_speed(ground):
    mission = read_mission(ground(radius="radius_m = 8.0\nrange_m = 1.0", seconds=3000))
    assert mission.notes == ("sensor.range_m allows 2 m/s; nothing flies faster",)


def test_ground_behind_rocks_is_left_out_with_a_note(ground, tmp_path):
    path = ground(seconds=3000)
    rock = np.zeros((HEIGHT, WIDTH), int)
    rock[:, 30] = 1
    np.savetxt(tmp_path / "rock.csv", rock, delimiter=",", fmt="%d")
    mission = read_mission(path)
    assert mission.notes == ("23.1% of the free ground cannot be reached from the start, and is left out",)
    assert (mission.problem.searcher.moves.graph.labels[:, 30:] == -1).all()


def test_time_for_a_way_but_for_no_search_is_refused_with_what_a_search_takes(ground):
    path = ground(more="[regions]\nspacing_m = 4.0")
    path.write_text(path.read_text().replace("end = [2, 2]", "").replace("seconds = 240", "seconds = 45"))
    with pytest.raises(DataFormatError, match=r"too short for searcher\[0\] to search any region; expected at least"):
        read_mission(path)


@pytest.mark.parametrize("cut", ["aware", "plain"])
@pytest.mark.parametrize("key", ["min_area_m2", "min_width_m"])
def test_least_sizes_that_leave_no_region_are_refused(ground, key, cut):
    path = ground(more=f'[regions]\ncut = "{cut}"\n{key} = 1e9')
    with pytest.raises(DataFormatError, match=rf"regions\.{key}: 1e\+09 m2? came, which leaves no region"):
        read_mission(path)


def test_time_for_more_actions_than_can_be_planned_is_refused_with_the_most(ground):
    with pytest.raises(DataFormatError, match=r"more than 50,000 actions .* expected at most \d+ s") as refused:
        read_mission(ground(seconds=1e9))
    most = int(str(refused.value).split("expected at most ")[1].split(" ")[0])
    assert read_mission(ground(seconds=most)).problem.searcher.budget == most


def test_cells_half_the_size_have_the_same_regions(ground, tmp_path):
    path = ground(more=PLAIN)
    coarse = read_mission(path).problem.searcher.moves.graph
    for name in ("rock", "theta"):
        fine = np.kron(np.loadtxt(tmp_path / f"{name}.csv", delimiter=","), np.ones((2, 2)))
        np.savetxt(tmp_path / f"{name}.csv", fine, delimiter=",", fmt="%.4f")
    path.write_text(path.read_text().replace("cell_m = 4.0", "cell_m = 2.0").replace("[2, 2]", "[4, 4]"))
    fine = read_mission(path).problem.searcher.moves.graph
    np.testing.assert_array_equal(fine.labels[::2, ::2], coarse.labels)


def test_aware_regions_are_more_and_smaller(ground):
    plain, aware = (
        read_mission(ground(more=f'[regions]\ncut = "{cut}"')).problem.searcher.moves.graph
        for cut in ("plain", "aware")
    )
    assert aware.n_regions > plain.n_regions
    assert (aware.labels >= 0).sum() >= (plain.labels >= 0).sum()


@pytest.mark.parametrize("moves", OVER)
def test_a_planner_that_does_not_know_the_moves_names_those_that_do(ground, moves):
    mission = read_mission(ground(moves=moves))
    wrong, right = ("topn", "depth-first") if moves == "regions" else ("depth-first", "topn")
    with pytest.raises(UnsupportedProblemError, match=f"for moves over {moves} there are: .*{right}"):
        plan_mission(mission, wrong, seconds=1.0)


@pytest.mark.parametrize("name", [name for name, entry in PLANNERS.items() if "regions" in entry.moves])
def test_every_planner_over_regions_plans_a_mission(ground, name):
    mission = read_mission(ground())
    assert solve(mission.problem, make_planner(name), max_ticks(3)).best.value > 0


def test_cells_of_one_look_are_worth_the_first_gain(ground):
    sight: Sight = read_mission(ground()).sight
    np.testing.assert_allclose(sight.worth(np.ones(HEIGHT * WIDTH, int)), sight.first_look)


def test_a_bound_of_no_time_is_not_told(ground):
    mission = read_mission(ground("belief", "detection", more="detection_target = 0.1"))
    planned = plan_mission(mission, seconds=1.0)
    best = replace(planned.solution.best, bound=-0.0, bound_proof="a proof", bound_assumes="much")
    told = replace(planned, solution=replace(planned.solution, best=best)).result(None)
    assert told["bound"] is told["bound_proof"] is told["bound_assumes"] is told["gap"] is None
    assert all(bound is None or bound < 0 for _, _, bound in told["trace"])


def test_a_drone_that_is_left_nothing_to_find_stays_as_it_is(ground):
    path = ground("belief", "detection", seconds=30000)
    text = path.read_text()
    drone = text[text.index("[[searcher]]") : text.index("[budget]")]
    path.write_text(text.replace("[budget]", drone + "[budget]"))
    mission = read_mission(path)
    planned = plan_mission(mission, seconds=2.0)
    assert np.isfinite(planned.score.evaluation.total)
