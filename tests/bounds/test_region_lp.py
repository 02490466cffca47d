from dataclasses import fields, replace

import numpy as np
import pytest

from sooner.bounds import RegionLP, bounds
from sooner.bounds.region_lp import Levels, picked_by_rate
from sooner.bounds.region_network import Cut, Prices, RegionNetwork
from sooner.bounds.stacked_ground import stacked
from sooner.errors import UnsupportedProblemError
from sooner.problem import Gains, Plan, Searcher, evaluate
from sooner.problem.region_ground import RegionGround
from sooner.scenarios import bimodal

from ..planners.region_worlds import all_walks, best_by_enumeration, region_world, unlike_team

SHAPES = [
    pytest.param(legs, ends, id=f"{'legs' if legs else 'centre'}-{'home' if ends else 'open'}")
    for legs in (False, True)
    for ends in (False, True)
]


def remote_world(seed, **shape):
    """A world whose edges pay nothing but near their ends: walks must be made to hold together."""
    problem = region_world(seed, **shape)
    moves = problem.searcher.moves
    edges = np.arange(moves.graph.n_regions, moves.graph.n_regions + moves.graph.n_edges)
    of_edges = np.unique(np.concatenate([moves.atoms.of(edge) for edge in edges]))
    table = problem.gains.table.copy()
    table[of_edges] *= 0.02
    return replace(problem, gains=Gains(table, problem.gains.ratio))


@pytest.mark.parametrize(("legs", "ends"), SHAPES)
@pytest.mark.parametrize("make", [region_world, remote_world])
@pytest.mark.parametrize("seed", range(4))
def test_no_walk_passes_any_bound_and_bounds_never_rise(make, seed, legs, ends):
    problem = make(seed, n_regions=4, budget=14.0, extra=seed % 3, legs=legs, ends=ends)
    found = [each.value for each in RegionLP().bounds(problem)]
    assert found == sorted(found, reverse=True)
    assert found[-1] >= best_by_enumeration(problem)
    assert found[-1] < 1.5 * best_by_enumeration(problem)


@pytest.mark.parametrize("seed", range(6))
def test_the_bound_holds_for_any_prices(seed):
    problem = region_world(seed, n_regions=4, budget=13.0, legs=True, ends=seed % 2 == 1)
    network, rng = RegionNetwork.of(problem), np.random.default_rng(seed)
    best, ground = best_by_enumeration(problem), network.ground
    for _ in range(40):
        inside = rng.random(4) < 0.5
        inside[network.firsts] = False
        cuts = [Cut(inside, int(region)) for region in np.flatnonzero(inside)]
        prices = Prices(
            rng.random(len(ground.gains)) * ground.gains[:, 0] * rng.random() * 1.2,
            rng.random(len(cuts)) * rng.random() * 3,
            rng.random(4) * (rng.random(4) < 0.3),
        )
        assert network.bound(prices, cuts) >= best


def test_cuts_make_walks_hold_together():
    gained = 0.0
    for seed in range(4):
        problem = remote_world(seed, n_regions=5, budget=14.0, extra=0)
        loose = RegionNetwork.of(problem)
        without = _without_cuts(loose)
        with_cuts = list(RegionLP().bounds(problem))[-1].value
        assert with_cuts <= without * (1.0 + 1e-6)
        gained += without / with_cuts - 1.0
    assert gained > 0.01


def _without_cuts(network):
    class Loose(RegionNetwork):
        def violated(self, counts, ending, visited, slack=1e-3):
            return []

    loose = Loose(**{each.name: getattr(network, each.name) for each in fields(network)})
    return min(value for value, _ in RegionLP().solutions(loose))


def test_narrow_and_wide_windows_prove_the_same():
    for seed in range(3):
        problem = region_world(seed, n_regions=5, budget=30.0, legs=True)
        values = [list(RegionLP(width=width).bounds(problem))[-1].value for width in (1, 2, 12)]
        assert values == pytest.approx([values[0]] * 3, rel=1e-4)


def test_a_window_is_exact_inside_and_never_too_low_outside():
    rng = np.random.default_rng(1)
    gains = np.hstack([np.sort(rng.random((3, 6)))[:, ::-1], np.zeros((3, 1))])
    lo, hi = np.array([0, 2, 3]), np.array([2, 4, 5])
    levels = Levels(gains, lo, hi)
    for atom in range(3):
        own = levels.atoms == atom
        for looks in range(7):
            left, value = looks - lo[atom], gains[atom, : lo[atom]].sum()
            if left < 0:
                value += left * levels.paid[own][0]
            for paid, most in zip(levels.paid[own], levels.most[own], strict=True):
                taken = min(max(left, 0), most)
                value, left = value + taken * paid, left - taken
            true = gains[atom, :looks].sum()
            assert value >= true - 1e-12
            if lo[atom] <= looks <= hi[atom]:
                assert value == pytest.approx(true)


def test_several_searchers_are_bounded_together():
    problem = region_world(3, n_regions=3, budget=8.0, legs=False)
    moves = problem.searcher.moves
    other = replace(moves, first=(moves.first + 1) % 3)
    team = replace(problem, searchers=(problem.searcher, Searcher(problem.searcher.start, 6.0, None, other)))
    second = replace(problem, searchers=team.searchers[1:])
    best = max(
        evaluate(team, Plan(tuple(np.array(walk) for walk in pair))).value
        for pair in _pairs(
            {tuple(sorted(w)): w for w in all_walks(problem)}, {tuple(sorted(w)): w for w in all_walks(second)}
        )
    )
    value = list(RegionLP().bounds(team))[-1].value
    alone = list(RegionLP().bounds(problem))[-1].value
    assert best <= value
    assert value > alone


@pytest.mark.parametrize("seed", range(6))
def test_searchers_that_fly_unlike_one_another_are_bounded_together(seed):
    team = unlike_team(seed)
    alone = [replace(team, searchers=(searcher,)) for searcher in team.searchers]
    best = max(
        evaluate(team, Plan(tuple(np.array(walk) for walk in pair))).value
        for pair in _pairs(*({tuple(sorted(w)): w for w in all_walks(one)} for one in alone))
    )
    value = list(RegionLP().bounds(team))[-1].value
    assert best <= value <= 1.5 * best


def test_the_ground_of_one_kind_is_not_changed_by_stacking():
    ground = RegionGround.of(region_world(4, n_regions=4, legs=True))
    once = stacked([ground])
    for each in fields(ground):
        np.testing.assert_array_equal(getattr(once, each.name), getattr(ground, each.name), err_msg=each.name)


def test_a_stacked_ground_holds_a_copy_of_each():
    grounds = [RegionGround.of(replace(team, searchers=(one,))) for team in (unlike_team(2),) for one in team.searchers]
    both = stacked(grounds)
    for region in range(both.n_regions):
        kind, own = divmod(region, grounds[0].n_regions)
        for (action, there), (way, end) in zip(both.ways_from(region), grounds[kind].ways_from(own), strict=True):
            assert there == end + kind * grounds[0].n_regions
            assert both.seconds[action] == grounds[kind].seconds[way]
            held, was = (
                each.atoms[each.starts[a] : each.starts[a + 1]] for each, a in ((both, action), (grounds[kind], way))
            )
            np.testing.assert_array_equal(held, was)
    for atom in range(len(both.gains)):
        covers = both.covers[both.cover_starts[atom] : both.cover_starts[atom + 1]]
        assert sorted(covers) == [a for a in range(both.n_actions) for k in _atoms(both, a) if k == atom]


def _atoms(ground, action):
    return ground.atoms[ground.starts[action] : ground.starts[action + 1]]


def _pairs(ones, others):
    return [(one, other) for one in ones.values() for other in others.values()]


def test_actions_picked_by_rate_are_those_of_the_reference():
    from sooner.planners.depth_first import relaxation

    for seed in range(4):
        network = RegionNetwork.of(region_world(seed, n_regions=5, budget=60.0))
        value, counts = relaxation(network.ground)
        assert picked_by_rate(network).tolist() == counts.tolist()
        assert value > 0


def test_what_cannot_be_reached_in_time_collects_nothing():
    problem = region_world(0, n_regions=5, budget=8.0, extra=0)
    network = RegionNetwork.of(problem)
    flown = {action for walk in all_walks(problem) for action in walk}
    assert flown <= set(np.flatnonzero(network.most).tolist())
    assert len(np.flatnonzero(network.most)) < network.ground.n_actions


def test_bounds_know_regions_and_refuse_what_has_no_end():
    problem = region_world(0, n_regions=3, budget=12.0)
    assert next(iter(bounds(problem))).proof == "linear program over regions"
    with pytest.raises(UnsupportedProblemError, match="over regions"):
        next(RegionLP().bounds(bimodal().problem()))
    for_ever = replace(problem, gains=Gains(problem.gains.table, np.full(problem.gains.n_cells, 0.5)))
    with pytest.raises(UnsupportedProblemError, match="end with their table"):
        next(RegionLP().bounds(for_ever))
