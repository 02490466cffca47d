"""No plan passes a bound: enumeration on tiny maps, and the formulas written out in plain Python."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.bounds import Bound, ConnectedSubgraph, _kernels, bounds
from sooner.bounds.connected_subgraph import _Dual, _Network
from sooner.errors import UnsupportedProblemError
from sooner.grid import Grid
from sooner.problem import CellMoves, Gains, Searcher, SearchProblem
from tests.oracles.time_expanded import exact_optimum
from tests.oracles.walks import optimum, total, walks
from tests.strategies import problems

QUICK = ConnectedSubgraph(separate_every=1, smallest_cut=0.0, iterations=10)


def first(bounds_so_far, count: int) -> list[Bound]:
    return list(itertools.islice(bounds_so_far, count))


@settings(max_examples=150, deadline=None)
@given(problems(most_steps=5), st.booleans())
def test_no_plan_passes_any_bound_on_the_way(problem, balance):
    best = optimum(problem)
    found = first(replace(QUICK, balance=balance).bounds(problem), 60)
    assert all(bound.value >= best for bound in found)
    assert all(later.value <= sooner.value for sooner, later in itertools.pairwise(found))


@settings(max_examples=150, deadline=None)
@given(problems(most_steps=5), st.sampled_from([1.0, 0.999, 0.9, 0.5]))
def test_taking_cells_off_the_map_never_cuts_below_the_optimum(problem, share):
    best = optimum(problem)
    for bound in first(QUICK.bounds(problem, lambda: share * best), 80):
        assert bound.value >= best


@settings(max_examples=60, deadline=None)
@given(problems(most_steps=5))
def test_all_proofs_together_start_at_teleport_and_fall(problem):
    best, found = optimum(problem), first(bounds(problem, -np.inf), 30)
    assert found[0].proof == "teleport"
    assert all(later.value <= sooner.value for sooner, later in itertools.pairwise(found))
    assert found[-1].value >= best
    assert all(bound.assumes for bound in found)


def formula(network: _Network, mu: float, lam: np.ndarray, cuts: list[tuple[list[tuple[int, int]], int, float]]):
    """Equation (3) as it stands in the docstring: cuts are (arcs (u, v), cell charged, price)."""
    n = network.n_cells
    around = [[int(u) for u in network.neighbours[v] if u >= 0] for v in range(n)]

    def gain(v: int, k: int) -> float:
        row = network.table[v]
        return float(row[k] if k < len(row) else row[-1] * network.ratio[v] ** (k - len(row) + 1))

    price = {(u, v): mu - lam[v] + lam[u] for v in range(n) for u in around[v]}
    value = mu * network.steps - float(network.ends @ lam) - network.n_open * lam.min()
    for v in range(n):
        entries = [price[u, v] for u in around[v]] + ([mu] if network.hover else [])
        looks = range(max(network.free[v], 1), max(network.free[v], 1) + network.steps)
        again = sum(max(gain(v, k) - min(entries), 0.0) for k in looks) if entries else 0.0
        if network.free[v]:
            value += again + network.free[v] * lam[v] + sum(gain(v, k) for k in range(network.free[v]))
        elif around[v]:
            least = min(price[u, v] - sum(y for arcs, _, y in cuts if (u, v) in arcs) for u in around[v])
            charged = sum(y for _, cell, y in cuts if cell == v)
            value += max(gain(v, 0) + again - charged - least, 0.0)
    return value


def random_multipliers(network: _Network, seed: int):
    rng = np.random.default_rng(seed)
    lam = rng.normal(size=network.n_cells) * rng.choice([0.0, 0.1, 1.0])
    mu = float(rng.choice([0.0, 0.3, 1.0, 2.0]))
    return rng, mu, lam


def kept_cuts(dual: _Dual) -> list[tuple[list[tuple[int, int]], int, float]]:
    degree, cuts = dual.network.neighbours.shape[1], dual.cuts
    found = []
    for c in range(cuts.count):
        into, slot = np.divmod(cuts.arcs[cuts.pointers[c] : cuts.pointers[c + 1]], degree)
        arcs = [(int(dual.network.neighbours[v, d]), int(v)) for v, d in zip(into, slot, strict=True)]
        found.append((arcs, int(cuts.cells[c]), float(cuts.prices[c])))
    return found


def finish(generator):
    while True:
        try:
            next(generator)
        except StopIteration as stop:
            return stop.value


@settings(max_examples=100, deadline=None)
@given(problems(most_steps=4), st.integers(0, 10**6))
def test_any_multipliers_are_valid_and_the_kernels_are_the_formula(problem, seed):
    network = _Network.of(problem)
    if network.unit <= 0:
        return
    rng, mu, lam = random_multipliers(network, seed)
    best = optimum(problem) / network.unit
    dual = _Dual(network, replace(QUICK, smallest_cut=-1.0), lambda: -np.inf)
    raised = finish(dual.evaluate(mu, lam, keep_cuts=True))
    assert best <= raised * (1 + 1e-9) + 1e-9
    assert raised <= formula(network, mu, lam, []) + 1e-9
    assert (dual.cost >= 0).all()
    assert (dual.prize >= 0).all()
    cuts = kept_cuts(dual)
    assert raised == pytest.approx(formula(network, mu, lam, cuts), rel=1e-9, abs=1e-9)

    dual.cuts.prices[: dual.cuts.count] = rng.exponential(size=dual.cuts.count)
    anything = formula(network, mu, lam, kept_cuts(dual))
    assert best <= anything * (1 + 1e-9) + 1e-9
    price, moments = np.array([mu, 0.0, 0.0, 0.0]), np.zeros((2, network.n_cells))
    here = _kernels.descend(
        network.neighbours, network.table, network.ratio, network.free, network.ends, network.n_open, network.steps,
        network.hover, price, lam.copy(), moments, dual.cuts.pointers, dual.cuts.arcs, dual.cuts.cells,
        dual.cuts.prices.copy(), dual.cuts.moments, dual.cuts.count, 0.02, 0.01, 1,
        np.zeros(network.neighbours.shape), np.zeros(network.n_cells),
    )  # fmt: skip
    assert here == pytest.approx(anything, rel=1e-9, abs=1e-9)


@settings(max_examples=100, deadline=None)
@given(problems(most_steps=4), st.integers(0, 10**6), st.floats(0.3, 1.0))
def test_cells_further_than_the_gap_lie_on_no_better_plan(problem, seed, share):
    network = _Network.of(problem)
    best = optimum(problem)
    if network.unit <= 0 or best <= 0:
        return
    _, mu, lam = random_multipliers(network, seed)
    lower = share * best
    dual = _Dual(network, QUICK, lambda: lower / network.unit)
    finish(dual.evaluate(mu, lam))
    dual.lam = lam
    kept = dual._worth_keeping()
    if kept is None:
        return
    within = {int(c) for c in np.flatnonzero(reachable(problem))[kept]}
    for walk in walks(problem):
        if not set(walk) <= within:
            assert total(problem, walk) <= lower


def reachable(problem: SearchProblem) -> np.ndarray:
    grid, searcher = problem.grid, problem.searcher
    there = grid.distances_from(grid.index(searcher.start))
    back = np.zeros_like(there) if searcher.end is None else grid.distances_from(grid.index(searcher.end))
    return (there >= 0) & (back >= 0) & (there + back <= searcher.budget)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6))
def test_every_cut_is_the_arcs_that_enter_a_set(seed):
    rng = np.random.default_rng(seed)
    network = _Network.of(islands(rng, (5, 5), 12))
    dual = _Dual(network, replace(QUICK, smallest_cut=-1.0), lambda: -np.inf)
    finish(dual.evaluate(0.8, rng.normal(size=network.n_cells) * 0.2, keep_cuts=True))
    flow = rng.random(network.neighbours.shape) * (network.neighbours >= 0) * 0.3
    dual._separate(flow, np.minimum(flow.sum(axis=1), 1.0), seed)
    for arcs, cell, _ in kept_cuts(dual):
        inside, blocked = {cell}, set(arcs)
        while True:  # everything that reaches the cell without an arc of the cut
            more = {
                int(u) for v in inside for u in network.neighbours[v] if u >= 0 and (int(u), v) not in blocked
            } - inside
            if not more:
                break
            inside |= more
        assert not any(network.free[v] for v in inside)


def islands(rng, shape: tuple[int, int], steps: int, **searcher) -> SearchProblem:
    weights = rng.random(shape) * (rng.random(shape) < 0.4) + 1e-3
    glimpse = rng.choice([1 / 3, 2 / 3, 1.0], shape)
    gains = Gains.independent(weights.ravel() / weights.sum(), glimpse.ravel())
    return SearchProblem(Grid(shape), gains, (Searcher((0, 0), steps, **searcher),))


def test_balance_is_tighter_than_plain_and_plain_than_teleport():
    problem = islands(np.random.default_rng(3), (6, 6), 14)
    plain = first(ConnectedSubgraph(balance=False).bounds(problem), 50)[-1].value
    balanced = first(ConnectedSubgraph().bounds(problem), 90)[-1].value
    assert balanced < 0.995 * plain
    assert plain < 0.98 * problem.teleport.value


def test_the_bound_comes_close_to_the_optimum_of_tiny_maps():
    gaps = []
    for seed in range(8):
        problem = islands(np.random.default_rng(seed), (3, 3), 6)
        best = optimum(problem)
        found = first(QUICK.bounds(problem, best), 150)[-1].value
        gaps.append(found / best - 1)
    assert np.median(gaps) < 0.02
    assert min(gaps) >= 0


def test_a_walk_along_a_line_is_proved_optimal():
    gains = Gains.independent(np.array([1.0, 5.0, 0.0, 4.0, 4.0]) / 14, np.ones(5))
    problem = SearchProblem(Grid((1, 5)), gains, (Searcher((0, 2), 2),))
    found = first(ConnectedSubgraph().bounds(problem, optimum(problem)), 2000)[-1].value
    assert found == pytest.approx(optimum(problem), rel=1e-4)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6))
def test_a_team_is_bounded_together(seed):
    rng = np.random.default_rng(seed)
    kind = rng.choice(["copter", "fixed_wing"])
    cells = [(int(rng.integers(2)), int(rng.integers(4))) for _ in range(3)]
    one = islands(rng, (2, 4), 3)
    searchers = (
        Searcher(cells[0], 3, moves=CellMoves(kind)),
        Searcher(cells[0] if rng.random() < 0.5 else cells[1], 2, moves=CellMoves("copter")),
    )
    problem = replace(one, searchers=searchers)
    flights = [list(walks(replace(problem, searchers=(each,)))) for each in searchers]
    best = max(total(problem, a + b) for a in flights[0] for b in flights[1])
    for bound in first(QUICK.bounds(problem, best * float(rng.choice([0.5, 1.0]))), 60):
        assert bound.value >= best


def test_what_cannot_be_bounded_is_refused():
    problem = islands(np.random.default_rng(0), (2, 2), 3)
    drifting = replace(problem, drift=object())
    with pytest.raises(UnsupportedProblemError):
        next(iter(ConnectedSubgraph().bounds(drifting)))
    assert list(bounds(drifting)) == []


@pytest.mark.parametrize(("seed", "end"), [(0, None), (1, (3, 3)), (2, None), (3, (0, 0))])
def test_the_bound_holds_against_an_integer_program(seed, end):
    problem = islands(np.random.default_rng(seed), (4, 4), 8, end=end)
    best = exact_optimum(problem)
    for known in (-np.inf, best):
        found = first(QUICK.bounds(problem, known), 60)
        assert all(bound.value >= best * (1 - 1e-9) for bound in found)
        assert found[-1].value <= 1.1 * best
