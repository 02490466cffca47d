"""Teams that plan for themselves: what was not heard does not count, and perfect links are central planning."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from sooner.bounds import bounds
from sooner.errors import InvalidProblemError
from sooner.planners import Greedy, max_ticks, solve
from sooner.planners.decentralised import Decentralised, Exchange, Links
from sooner.planners.region_anneal import RegionAnneal
from sooner.planners.region_greedy import RegionGreedy
from sooner.planners.registry import make_planner
from sooner.planners.team import Team
from sooner.problem import evaluate
from tests.planners.contract import check_contract
from tests.planners.region_worlds import region_world
from tests.planners.test_team import two_hills
from tests.strategies import problems

INNER = RegionAnneal(moves=300, longest=20, walks=2)


def team_world(seed, searchers=3, regions=5, budget=16.0):
    """Searchers over one graph, starting in regions apart: metres between their starts are those of cells."""
    problem = region_world(seed, regions, budget, extra=2)
    labels = problem.searcher.moves.graph.labels
    team = []
    for number in range(searchers):
        region = (seed + number) % regions
        start = problem.grid.cell(int(np.flatnonzero((labels == region).ravel())[0]))
        team.append(replace(problem.searcher, start=start, moves=replace(problem.searcher.moves, first=region)))
    return replace(problem, searchers=tuple(team))


def exchanged(problem, links, inner=INNER, rounds=1, ticks=6, seed=0) -> Exchange:
    told = []
    planner = Decentralised(inner, links, rounds, ticks, tell=told.append)
    solution = solve(problem, planner, seed=seed)
    (exchange,) = told
    assert solution.best.value == exchange.value == evaluate(problem, exchange.plan).value
    assert solution.best.plan == exchange.plan
    return exchange


@settings(max_examples=30)
@given(problem=problems())
def test_a_decentralised_team_of_one_keeps_the_contract(problem):
    planner = Decentralised(make_planner("greedy"))
    assume(planner.handles(problem) is None)
    check_contract(problem, planner)


@pytest.mark.parametrize("seed", range(4))
def test_links_that_lose_nothing_and_reach_all_are_central_planning(seed):
    problem = team_world(seed)
    central = solve(problem, Team(INNER, rounds=1, ticks=6), seed=seed).best
    exchange = exchanged(problem, Links(), seed=seed)
    assert exchange.plan == central.plan
    assert exchange.value == central.value
    assert exchange.knows.all()
    assert (exchange.believed == exchange.value).all()
    assert exchange.lost == 0
    assert exchange.sent == 3 * 2 * (1 + 2)  # each to two others: at first, and after each of two rounds


def test_perfect_links_over_cells_are_central_planning_too():
    problem = two_hills((2, 0), (2, 10), (0, 5))
    central = solve(problem, Team(Greedy())).best
    assert exchanged(problem, Links(), Greedy(), rounds=2, ticks=20).plan == central.plan


@pytest.mark.parametrize("links", [Links(range_m=0.0), Links(loss=1.0)])
def test_without_links_everyone_flies_the_best_flight_alone(links):
    problem = team_world(1)
    exchange = exchanged(problem, links, RegionGreedy())
    for searcher, flight in zip(problem.searchers, exchange.plan.actions, strict=True):
        alone = replace(problem, searchers=(searcher,))
        assert np.array_equal(flight, solve(alone, RegionGreedy()).best.plan.actions[0])
    assert (exchange.knows == np.eye(3, dtype=bool)).all()
    assert exchange.lost == exchange.sent == (0 if links.loss == 0 else 18)


def test_from_one_start_without_links_all_fly_the_same_flight():
    alone = region_world(1, 5, 16.0, extra=2)
    problem = replace(alone, searchers=alone.searchers * 2)
    exchange = exchanged(problem, Links(loss=1.0), RegionGreedy())
    assert np.array_equal(*exchange.plan.actions)
    assert exchange.value < exchanged(problem, Links(), RegionGreedy()).value


@settings(max_examples=15)
@given(seed=st.integers(0, 50), loss=st.sampled_from([0.0, 0.3, 0.7, 1.0]), range_m=st.sampled_from([0.0, 8.0, 100.0]))
def test_nobody_counts_a_flight_that_it_has_not_heard(seed, loss, range_m):
    problem = team_world(seed)
    links = Links(range_m, loss, relays=False)
    exchange = exchanged(problem, links, RegionGreedy())
    reached = {(m.receiver, m.sender) for m in exchange.messages if m.heard}
    knows = {(int(one), int(other)) for one, other in np.argwhere(exchange.knows) if one != other}
    assert knows <= reached
    assert all(links.in_range(problem)[m.sender, m.receiver] for m in exchange.messages)
    for number in set(range(3)) - {receiver for receiver, _ in reached}:
        alone = replace(problem, searchers=(problem.searchers[number],))
        assert exchange.believed[number] == solve(alone, RegionGreedy()).best.value


def test_relayed_flights_reach_those_out_of_range():
    problem = team_world(0, searchers=3)  # in a row, six metres apart
    assert Links(range_m=8.0).in_range(problem).tolist() == [[0, 1, 0], [1, 0, 1], [0, 1, 0]]
    near = exchanged(problem, Links(8.0, relays=False), RegionGreedy())
    far = exchanged(problem, Links(8.0), RegionGreedy())
    assert not near.knows[0, 2]
    assert not near.knows[2, 0]
    assert far.knows[2, 0]


def test_the_same_seed_loses_the_same_messages_and_another_seed_others():
    problem = team_world(2)
    one, again, other = (exchanged(problem, Links(loss=0.5), seed=seed) for seed in (1, 1, 2))
    assert one.messages == again.messages
    assert one.plan == again.plan
    assert one.messages != other.messages


@pytest.mark.parametrize("seed", range(3))
def test_a_decentralised_team_stays_below_what_is_proved(seed):
    problem = team_world(seed)
    value = exchanged(problem, Links(loss=0.5), seed=seed).value
    assert value <= min(bound.value for bound in islice(bounds(problem), 20)) + 1e-9


def test_a_run_by_the_clock_ends_with_what_the_team_is_left_with():
    problem, told = team_world(0), []
    ticks = Decentralised(INNER, Links(loss=0.5), tell=told.append).plans(problem, np.random.default_rng(0))
    next(ticks)
    for share in np.linspace(0.0, 0.99, 100):
        try:
            last = ticks.send(float(share))
        except StopIteration:
            break
    assert told[0].value == last.value


@pytest.mark.parametrize("settings", [{"range_m": -1.0}, {"range_m": np.nan}, {"loss": 1.5}, {"loss": -0.1}])
def test_links_that_make_no_sense_are_refused(settings):
    with pytest.raises(InvalidProblemError, match="came; expected"):
        Links(**settings)


def test_a_planner_that_tells_is_the_same_planner():
    assert Decentralised(INNER, tell=print) == Decentralised(INNER)
    with pytest.raises(InvalidProblemError, match="-1 rounds"):
        Decentralised(INNER, rounds=-1)
    assert solve(team_world(0), Decentralised(RegionGreedy()), max_ticks(50)).best.value > 0
