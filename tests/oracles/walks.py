"""Every legal walk, one by one; neighbours from geometry, gains from the definition."""

from collections.abc import Iterator

import numpy as np

from sooner.problem import SearchProblem


def adjacent(problem: SearchProblem) -> dict[int, list[int]]:
    """Neighbours found by distance between centres, corners of obstacles not cut."""
    grid = problem.grid
    centres = grid.centres_m / grid.cell_m
    limit = 1.5 if grid.connectivity == "square8" else 1.01
    near: dict[int, list[int]] = {}
    for i in range(grid.n_cells):
        near[i] = []
        for j in range(grid.n_cells):
            if i == j or not grid.passable[i] or not grid.passable[j]:
                continue
            if np.hypot(*(centres[i] - centres[j])) > limit:
                continue
            (r, c), (s, d) = grid.cell(i), grid.cell(j)
            if grid.connectivity == "square8" and r != s and c != d:
                beside = (grid.index((r, d)), grid.index((s, c)))
                if not all(grid.passable[b] for b in beside):
                    continue
            near[i].append(j)
    return near


def walks(problem: SearchProblem) -> Iterator[list[int]]:
    """All walks of exactly T steps that keep every rule."""
    searcher = problem.searcher
    near = adjacent(problem)
    wing = searcher.moves.kind == "fixed_wing"
    start = problem.grid.index(searcher.start)
    came_from = None if searcher.came_from is None else problem.grid.index(searcher.came_from)
    end = None if searcher.end is None else problem.grid.index(searcher.end)

    def extend(walk: list[int]) -> Iterator[list[int]]:
        if len(walk) == searcher.budget + 1:
            if end is None or walk[-1] == end:
                yield list(walk)
            return
        before = walk[-2] if len(walk) > 1 else came_from
        for cell in near[walk[-1]] + ([] if wing else [walk[-1]]):
            if wing and cell == before:
                continue
            walk.append(cell)
            yield from extend(walk)
            walk.pop()

    yield from extend([start])


def total(problem: SearchProblem, walk: list[int]) -> float:
    """Gains of the looks of a walk, from the definition of the table and its tail."""
    seen: dict[int, int] = {}
    value = 0.0
    for cell in walk:
        k = seen.get(cell, 0)
        row, ratio = problem.gains.table[cell], problem.gains.ratio[cell]
        value += row[k] if k < len(row) else row[-1] * ratio ** (k - len(row) + 1)
        seen[cell] = k + 1
    return float(value)


def optimum(problem: SearchProblem) -> float:
    """The most that any legal walk of T steps collects; minus infinity where there is none."""
    return max((total(problem, walk) for walk in walks(problem)), default=-np.inf)


def soonest(problem: SearchProblem) -> float:
    """Fewest steps in which any legal walk reaches the target; infinity where none does."""
    best = np.inf
    target = problem.objective.target
    assert target is not None
    for walk in walks(problem):
        for time in range(len(walk)):
            if time < best and total(problem, walk[: time + 1]) >= target:
                best = time
    return best
