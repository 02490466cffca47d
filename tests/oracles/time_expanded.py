"""The exact optimum of a small problem over cells, as a mixed-integer program over time and cells (HiGHS)."""

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from sooner.problem import SearchProblem
from tests.oracles.walks import adjacent


def exact_optimum(problem: SearchProblem) -> float:
    """The most that a copter collects in T steps: one step variable per arc and time, one per look."""
    searcher, gains = problem.searcher, problem.gains
    steps, near = searcher.budget, adjacent(problem)
    arcs = [(u, v) for u in near for v in [*near[u], u]]
    start = problem.grid.index(searcher.start)
    n, n_arcs, looks = problem.grid.n_cells, len(arcs), steps + 1
    n_moves = n_arcs * steps
    rows, cols, values, right, exact = [], [], [], [], []

    def add(terms: list[tuple[int, float]], value: float, equal: bool) -> None:
        row = len(right)
        for column, factor in terms:
            rows.append(row)
            cols.append(column)
            values.append(factor)
        right.append(value)
        exact.append(equal)

    for t in range(steps):
        for v in range(n):
            out = [(t * n_arcs + a, 1.0) for a, (u, _) in enumerate(arcs) if u == v]
            into = [((t - 1) * n_arcs + a, -1.0) for a, (_, w) in enumerate(arcs) if w == v] if t else []
            add(out + into, float(t == 0 and v == start), True)
    for v in range(n):
        visits = [(t * n_arcs + a, -1.0) for t in range(steps) for a, (_, w) in enumerate(arcs) if w == v]
        add([(n_moves + v * looks + k, 1.0) for k in range(looks)] + visits, float(v == start), False)
    if searcher.end is not None:
        end = problem.grid.index(searcher.end)
        add([((steps - 1) * n_arcs + a, 1.0) for a, (_, w) in enumerate(arcs) if w == end], 1.0, True)
    pays = np.array([[gains.of(np.array(v), np.array(k)) for k in range(looks)] for v in range(n)], float)
    cost = np.concatenate([np.zeros(n_moves), -pays.ravel()])
    matrix = coo_array((values, (rows, cols)), shape=(len(right), len(cost))).tocsr()
    lower = np.where(exact, right, -np.inf)
    found = milp(
        cost,
        constraints=LinearConstraint(matrix, lower, right),
        integrality=np.ones(len(cost)),
        bounds=Bounds(0, 1),
        options={"mip_rel_gap": 0.0},
    )
    assert found.success
    return float(-found.fun)
