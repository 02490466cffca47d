"""Small searches over regions, drawn at random: footprints that overlap, gains of any concave kind."""

from dataclasses import replace

import numpy as np

from sooner.grid import Grid
from sooner.problem import Gains, Plan, Searcher, SearchProblem, evaluate
from sooner.problem.atoms import Footprints, atom_gains, atoms_of
from sooner.problem.common_atoms import common_atoms
from sooner.problem.regions import RegionGraph, RegionMoves

COLUMNS = 12


def region_world(
    seed: int = 0, n_regions: int = 4, budget: float = 40.0, extra: int = 2, legs: bool = False, ends: bool = False
) -> SearchProblem:
    """A connected graph over a strip of cells; searches cover their region, edges a bit of both.

    Where the seed is odd, an action looks twice or three times at some of its cells.
    """
    rng = np.random.default_rng(seed)
    width = 6
    grid = Grid((4, width * n_regions))
    labels = np.repeat(np.arange(n_regions), width)[None, :].repeat(4, axis=0).astype(np.int32)
    pairs = {tuple(sorted((int(rng.integers(0, r)), r))) for r in range(1, n_regions)}
    for _ in range(extra):
        one, other = rng.choice(n_regions, 2, replace=False) if n_regions > 1 else (0, 0)
        if one != other:
            pairs.add(tuple(sorted((int(one), int(other)))))
    edges = np.array(sorted(pairs), np.int64).reshape(-1, 2)
    centres = np.array([np.mean(grid.centres_m[(labels == r).ravel()], axis=0) for r in range(n_regions)])
    covers, paths, seconds = [], [], []
    for r in range(n_regions):
        own = np.flatnonzero((labels == r).ravel())
        beyond = rng.choice(grid.n_cells, 3, replace=False)
        covers.append(np.union1d(own[rng.random(own.size) < 0.9], beyond))
        paths.append(np.stack([centres[r], centres[r] + 1.0, centres[r]]))
        seconds.append(rng.uniform(3, 7))
    for one, other in edges:
        near = np.flatnonzero(np.isin(labels.ravel(), (one, other)))
        covers.append(rng.choice(near, max(len(near) // 6, 1), replace=False))
        paths.append(centres[[one, other]])
        seconds.append(rng.uniform(1, 3))
    first, last = int(rng.integers(n_regions)), int(rng.integers(n_regions)) if ends else -1
    depart = back = -1
    if legs:
        depart, back = len(covers), len(covers) + 1 if ends else -1
        for region in (first, last)[: 1 + ends]:
            covers.append(rng.choice(grid.n_cells, 4, replace=False))
            paths.append(centres[[region, region]])
            seconds.append(0.5)
    starts = np.concatenate([[0], np.cumsum([len(cells) for cells in covers])])
    cells = np.concatenate([np.sort(cells) for cells in covers]).astype(np.int32)
    when = rng.uniform(0, 1, len(cells)).astype(np.float32)
    footprints = Footprints(starts, cells, when, 1 - when)
    footprints = looking_again(footprints, seed) if seed % 2 else footprints
    graph = RegionGraph(n_regions, edges, np.array(seconds), tuple(paths), footprints, labels)
    atoms = atoms_of(footprints, grid.n_cells)
    gains = cell_gains(grid, rng)
    moves = RegionMoves(graph, atoms, first, last, depart, back)
    start = grid.cell(int(np.flatnonzero((labels == first).ravel())[0]))
    end = grid.cell(int(np.flatnonzero((labels == last).ravel())[0])) if ends else None
    searcher = Searcher(start, budget, end, moves)
    return SearchProblem(
        grid, atom_gains(atoms, lambda asked: gains.of(asked[:, None], np.arange(COLUMNS))), (searcher,)
    )


def looking_again(footprints: Footprints, seed: int) -> Footprints:
    """The same, with some cells looked at twice or three times in an action, one time unit apart."""
    rng = np.random.default_rng(1000 + seed)
    times = rng.choice(3, len(footprints.cells), p=[0.6, 0.3, 0.1]) + 1
    which = np.repeat(np.arange(len(times)), times)
    later = (np.arange(len(which)) - np.repeat(np.cumsum(times) - times, times)).astype(np.float32)
    starts = np.concatenate([[0], np.cumsum(times)])[footprints.starts]
    seconds, back = footprints.seconds[which] + later, footprints.back_s[which] + later
    return Footprints(starts, footprints.cells[which], seconds, back)


def unlike_team(seed: int, n_regions: int = 3, budget: float = 8.0) -> SearchProblem:
    """Two searchers: the second flies half as fast again, and its searches see fewer cells."""
    one = region_world(seed, n_regions, budget)
    moves, rng = one.searcher.moves, np.random.default_rng(seed)
    graph, whole = moves.graph, moves.graph.footprints
    kept = [rng.random(len(whole.of(action))) < 0.8 for action in range(whole.n_actions)]
    seen = np.concatenate(kept)
    starts = np.concatenate([[0], np.cumsum([each.sum() for each in kept])])
    fewer = Footprints(starts, whole.cells[seen], whole.seconds[seen] / 1.5, whole.back_s[seen] / 1.5)
    atoms = common_atoms([whole, fewer], one.grid.n_cells)
    slow = replace(moves, atoms=atoms[0])
    quick_graph = replace(graph, seconds=graph.seconds / 1.5, footprints=fewer)
    quick = replace(moves, graph=quick_graph, atoms=atoms[1], first=(moves.first + 1) % n_regions)
    gains, start = cell_gains(one.grid, rng), one.searcher.start
    searchers = Searcher(start, budget, None, slow), Searcher(start, 0.7 * budget, None, quick)
    return SearchProblem(
        one.grid, atom_gains(atoms[0], lambda asked: gains.of(asked[:, None], np.arange(COLUMNS))), searchers
    )


def cell_gains(grid: Grid, rng: np.random.Generator) -> Gains:
    """Gains of cells: each its own concave row, and nothing after `COLUMNS` looks."""
    rows = np.sort(rng.random((grid.n_cells, COLUMNS)) ** 3, axis=1)[:, ::-1] * rng.random((grid.n_cells, 1))
    return Gains(np.ascontiguousarray(rows), np.zeros(grid.n_cells))


def all_walks(problem: SearchProblem):
    """Every legal plan that cannot be made longer, as tuples of actions: for tiny budgets."""
    moves, limit = problem.searcher.moves, problem.searcher.budget
    graph = moves.graph

    def longer(walk, here, left):
        open_actions = [
            (action, there)
            for action, there in [(here, here), *graph.ways[here]]
            if graph.seconds[action] + moves.to_last[there] <= left + 1e-9
        ]
        if walk and moves.last in (-1, here):
            yield tuple(walk)
        for action, there in open_actions:
            yield from longer([*walk, action], there, left - graph.seconds[action])

    yield from longer([], moves.first, limit - moves.leg_s)


def best_by_enumeration(problem: SearchProblem) -> float:
    """The best value of any legal plan; plans with the same actions in another order are judged once."""
    seen, best = set(), 0.0
    for walk in all_walks(problem):
        key = tuple(sorted(walk))
        if key not in seen:
            seen.add(key)
            best = max(best, evaluate(problem, Plan.of(list(walk))).value)
    return best
