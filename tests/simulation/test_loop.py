"""The closed loop: what it detects is so, what it scores is right, and it flies the same way twice."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from sooner.belief.cell_states import CellStates
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.sensors.graded import GradedSensor
from sooner.simulation import Agent, Call, Estimator, Keep, Scene, World, simulate
from sooner.simulation.strategies import Lawnmower, RandomWaypoints
from sooner.simulation.world import Purpose, generator
from sooner.streets import Evasive, OccupancyGraph
from tests.simulation.streets import blocks

GRAPH = blocks()
SCENE = Scene(World(GRAPH), seconds=90)
SHARP = Agent(map_sensor=GradedSensor(12.0, 61), target_sensor=GradedSensor(12.0, 61))


class Wrong:
    """A strategy that answers nonsense."""

    capture = 0.1

    def __init__(self, answer):
        self.answer = answer

    def starts(self, grid, agents, drawn):
        return drawn

    def session(self, situation, rng):
        return self

    def routes(self, situation):
        return self.answer


def test_one_seed_flies_the_same_search_twice_and_another_seed_another():
    one, again, other = (simulate(SCENE, RandomWaypoints(), seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(one.places_m, again.places_m)
    np.testing.assert_array_equal(one.node_seconds, again.node_seconds)
    assert one.calls == again.calls
    assert not np.array_equal(one.places_m, other.places_m)


def test_what_is_kept_changes_nothing():
    scene = replace(SCENE, estimator=Estimator(prior="kriged"))
    bare, kept = simulate(scene, RandomWaypoints(), 1), simulate(scene, RandomWaypoints(), 1, Keep(True, 7))
    np.testing.assert_array_equal(bare.sums, kept.sums)
    np.testing.assert_array_equal(bare.node_seconds, kept.node_seconds)
    assert len(kept.beliefs.seconds) == 13
    assert kept.looks.firsts[-1] == len(kept.looks.cells)


def test_two_strategies_of_one_seed_meet_the_same_targets_and_starts():
    one, other = simulate(SCENE, RandomWaypoints(), 5), simulate(SCENE, RandomWaypoints(capture=0.9), 5)
    np.testing.assert_array_equal(one.targets, other.targets)
    np.testing.assert_array_equal(one.places_m[0], other.places_m[0])


def test_targets_walk_on_edges_or_rest():
    path = simulate(SCENE, RandomWaypoints(), 2).targets[:, 0]
    joined = {tuple(edge) for edge in np.concatenate([GRAPH.edges, GRAPH.edges[:, ::-1]]).tolist()}
    assert all(a == b or (a, b) in joined for a, b in pairwise(path.tolist()))


def test_agents_start_on_the_perimeter():
    for seed in range(20):
        start = simulate(replace(SCENE, seconds=5), RandomWaypoints(), seed).places_m[0]
        edge = np.minimum(np.abs(start + 2.5), np.abs(start - 97.5)).min(axis=1)
        np.testing.assert_allclose(edge, 0.0, atol=1e-9)
        assert (start >= -2.5 - 1e-9).all()
        assert (start <= 97.5 + 1e-9).all()


def test_a_sharp_team_that_sees_everything_knows_it_at_once():
    scene = Scene(World(GRAPH), (replace(SHARP, radius_m=200.0),), seconds=20)
    flown = simulate(scene, RandomWaypoints(), 1)
    assert flown.false_nodes == 0
    assert flown.e_nodes == 0.5
    assert flown.e_targets > 0.4
    assert flown.calls[0].target == 0


def test_the_belief_of_cells_is_bayes_law_applied_to_the_looks_one_by_one():
    flown = simulate(replace(SCENE, estimator=Estimator("cbht")), RandomWaypoints(), 4, Keep(True, 1))
    sensor = GradedSensor()
    states = CellStates.unknown(GRAPH.grid.n_cells)
    v, u, o = states.void.copy(), states.unoccupied.copy(), states.occupied.copy()
    detected = np.zeros(len(v), bool)
    looks = flown.looks
    for second in range(30):
        for n in range(looks.firsts[second], looks.firsts[second + 1]):
            cell, g, z = looks.cells[n], looks.map_levels[n], looks.target_levels[n]
            if detected[cell]:
                continue
            v[cell] *= sensor.p_noise[g] * sensor.p_noise[z]
            u[cell] *= sensor.p_signal[g] * sensor.p_noise[z]
            o[cell] *= sensor.p_signal[g] * sensor.p_signal[z]
            total = v[cell] + u[cell] + o[cell]
            v[cell], u[cell], o[cell] = v[cell] / total, u[cell] / total, o[cell] / total
        detected |= (1 - v) / v >= 19
        np.testing.assert_allclose(flown.beliefs.void[second], v, atol=1e-12)
        np.testing.assert_allclose(flown.beliefs.occupied[second], o, atol=1e-12)
        np.testing.assert_array_equal((flown.node_seconds >= 0) & (flown.node_seconds <= second), detected)


def test_cells_of_nodes_are_told_by_the_tracker():
    flown = simulate(SCENE, RandomWaypoints(), 4, Keep(beliefs_s=10))
    for n, second in enumerate(flown.beliefs.seconds):
        nodes = (flown.node_seconds >= 0) & (flown.node_seconds <= second)
        assert not flown.beliefs.void[n][nodes].any()
        ratios = flown.beliefs.occupied[n][nodes] / (1 - flown.beliefs.occupied[n][nodes])
        assert ratios.sum() == pytest.approx(flown.sums[second], rel=1e-6)


def test_e_is_the_area_under_the_two_curves():
    flown = simulate(SCENE, Lawnmower(), 3)
    for half, curve in ((flown.e_nodes, flown.nodes_curve), (flown.e_targets, flown.targets_curve)):
        assert half == pytest.approx(0.5 * curve[:-1].mean())
    assert flown.e == flown.e_nodes + flown.e_targets


def test_e_counts_true_nodes_and_the_first_call_that_is_right():
    flown = simulate(replace(SCENE, world=World(GRAPH, n_targets=2)), Lawnmower(), 3)
    seconds = np.full(GRAPH.grid.n_cells, -1)
    seconds[0], seconds[GRAPH.cells[0]] = 0, 45
    calls = (Call(9, 0, -1), Call(30, 0, 1), Call(60, 0, 1))
    scored = replace(flown, node_seconds=seconds, calls=calls)
    assert scored.false_nodes == 1
    assert scored.false_calls == 1
    assert scored.e_nodes == pytest.approx(0.5 * 0.5 / GRAPH.n_nodes)
    assert scored.found_targets.tolist() == [-1, 30]
    assert scored.e_targets == pytest.approx(0.5 * (60 / 90) / 2)


def test_a_known_map_is_known_from_the_start():
    flown = simulate(replace(SCENE, estimator=Estimator(prior="known")), RandomWaypoints(), 1)
    assert flown.e_nodes == 0.5
    assert flown.false_nodes == 0


@pytest.mark.parametrize("detector", ["cbht", "lrdt"])
def test_without_a_target_every_call_is_false_and_there_are_few(detector):
    scene = replace(SCENE, world=World(GRAPH, n_targets=0), estimator=Estimator(detector))
    flown = [simulate(scene, Lawnmower(), seed) for seed in range(20)]
    assert all(call.target == -1 for each in flown for call in each.calls)
    assert np.isnan(flown[0].e)
    assert sum(each.false_calls > 0 for each in flown) <= 4


def test_detection_is_right_more_often_than_not():
    flown = [simulate(SCENE, Lawnmower(), seed) for seed in range(12)]
    assert np.mean([each.e_targets > 0 for each in flown]) > 0.5
    assert all(each.scene.world.n_targets == 1 and len(each.found_targets) == 1 for each in flown)


def test_shy_targets_leave_where_agents_hover():
    def in_view(evasive):
        places = np.array([[47.5, 47.5], [20.0, 70.0]])
        scene = Scene(World(GRAPH, n_targets=100, evasive=evasive), (Agent(),) * 2, seconds=60, starts_m=places)
        flown = simulate(scene, Wrong((np.empty((0, 2)),) * 2), 1)
        apart = places[:, None, None] - GRAPH.positions_m[flown.targets[30:]]
        return np.mean(np.linalg.norm(apart, axis=-1).min(axis=0) < 12.5)

    assert in_view(Evasive(np.empty((0, 2)), reach_m=12.5, boldness=0.01)) < 0.6 * in_view(None)


def test_several_targets_are_each_found_by_a_call_near_them():
    scene = Scene(World(GRAPH, n_targets=3), (SHARP,) * 4, seconds=120)
    flown = [simulate(scene, Lawnmower(), seed) for seed in range(6)]
    assert {call.target for each in flown for call in each.calls} >= {0, 1, 2}
    assert all(each.targets_curve[-1] <= 1.0 for each in flown)


def test_faster_and_keener_agents_know_more():
    plain, keen = Agent(), Agent(v_max=6.0, a_max=4.0, radius_m=17.5)
    mean = [
        np.mean([simulate(replace(SCENE, agents=team), RandomWaypoints(), seed).e_nodes for seed in range(8)])
        for team in ((plain,) * 4, (plain, plain, keen, keen), (keen,) * 4)
    ]
    assert mean[0] < mean[1] < mean[2]


def test_streams_of_one_seed_are_their_own():
    draws = {generator(9, purpose).random() for purpose in (Purpose.TARGETS, Purpose.STARTS, Purpose.STRATEGY)}
    assert len(draws) == 3


@pytest.mark.parametrize(
    "answer", [(np.zeros((1, 2)),), (np.full((1, 2), np.nan),) * 4, (np.zeros(3),) * 4, (np.zeros((1, 3)),) * 4]
)
def test_nonsense_for_routes_is_refused(answer):
    with pytest.raises(InvalidProblemError, match="came"):
        simulate(SCENE, Wrong(answer), 1)


def test_no_routes_at_all_are_refused():
    with pytest.raises(InvalidProblemError, match="answered None; expected a route for each agent"):
        simulate(SCENE, Wrong(None), 1)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"seconds": 0}, "0 s came"),
        ({"replan_s": 91}, "replan every 91 s"),
        ({"replan_s": 0}, "replan every 0 s"),
        ({"agents": ()}, "0 agents"),
        ({"starts_m": np.zeros((3, 2))}, "for 4 agents"),
        ({"starts_m": np.full((4, 2), 500.0)}, "starts 500 m east"),
        ({"starts_m": np.full((4, 2), np.nan)}, "starts nan m east"),
    ],
)
def test_impossible_scenes_are_refused(change, said):
    with pytest.raises(InvalidProblemError, match=said):
        replace(SCENE, **change)


@pytest.mark.parametrize(
    "bad",
    [{"detector": "x"}, {"prior": "x"}, {"odds": 0}, {"decay": 0}, {"void": 1}, {"detector": "cbht", "prior": "known"}],
)
def test_impossible_estimators_are_refused(bad):
    with pytest.raises(InvalidProblemError, match="came"):
        Estimator(**bad)


def test_a_negative_seed_is_refused():
    with pytest.raises(InvalidProblemError, match="seed -1"):
        simulate(SCENE, Lawnmower(), -1)


@pytest.mark.parametrize("n", [-1, 10_000])
def test_targets_in_impossible_numbers_are_refused(n):
    with pytest.raises(InvalidProblemError, match="targets came"):
        World(GRAPH, n_targets=n)


def test_a_single_node_can_be_searched():
    graph = OccupancyGraph.of(Grid((3, 3), "square8", 5.0), [4], np.empty((0, 2), int))
    assert simulate(Scene(World(graph), (Agent(),), seconds=20), Lawnmower(), 1).e_nodes > 0.3
