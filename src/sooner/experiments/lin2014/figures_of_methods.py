"""Figures 1, 5, 7 and 12 of Lin and Goodrich 2014: how its measures and its methods work, each flown for the figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.experiments.figures import draw_map, panels
from sooner.experiments.lin2014.claims import author_gaussians, ratios_of_author
from sooner.experiments.lin2014.figure_parts import Flown, draw_path, mark, surfaces
from sooner.experiments.lin2014.maps import posed
from sooner.planners import Greedy, Planner, max_ticks, solve
from sooner.planners.anneal import Anneal
from sooner.planners.global_warming import GlobalWarming
from sooner.planners.hill_climb import directions, random_state
from sooner.planners.mode_goodness import ModeGoodness
from sooner.planners.top2 import Top2
from sooner.planners.topn import TopN
from sooner.problem import Searcher, SearchProblem, evaluate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["figure_1", "figure_5", "figure_7", "figure_12"]


def figure_1(flown: Flown) -> Figure:
    """Two measures of a path, most by a time or soonest to a CDP: each is won by another path."""
    figure, (axes,) = panels(1, 1, 4.2, 2.9)
    steps, wanted = 600, 0.10
    problem = flown.problem("upper left", steps)
    planners: list[tuple[str, Planner]] = [("LHC-GW-CONV", GlobalWarming()), ("Top2", Top2()), ("anneal", Anneal())]
    for number, (name, planner) in enumerate(planners, 1):
        judged = evaluate(problem, solve(problem, planner, max_ticks(40)).best.plan)
        colour, soonest = ("#b35806", "#2166ac", "black")[number - 1], judged.time_to(wanted)
        axes.plot(judged.times, judged.cdp, color=colour, label=f"path {number} ({name})")
        axes.plot([soonest, steps], [wanted, judged.total], "o", ms=3.5, color=colour)
    axes.axvline(steps, color="#4393c3", ls=":", lw=1.2)
    axes.axhline(wanted, color="#d73027", ls=":", lw=1.2)
    axes.text(594, 0.003, "most by T = 600: path 3", ha="right", color="#4393c3")
    axes.text(594, wanted - 0.010, "soonest to 0.1: path 1", ha="right", color="#d73027")
    axes.set(xlabel="time step", ylabel="cumulative detection probability", xlim=(0, 625), ylim=(0, None))
    axes.legend(frameon=False)
    return figure


def figure_5(flown: Flown) -> Figure:
    """Top2: the time shared out between two hills in three ways; both climb to the point halfway between them."""
    problem = posed(flown.data, "simple_bimodalfar_diff1", (30, 30), 450)
    hills = _hills(problem, 2)
    near, far = sorted(hills, key=lambda hill: int(problem.grid.distances_from(problem.grid.index((30, 30)))[hill]))
    cells = [problem.grid.cell(hill) for hill in (near, far)]
    centre = (sum(cell[0] for cell in cells) // 2, sum(cell[1] for cell in cells) // 2)
    figure, axes = panels(1, 3, 2.6, 2.75)
    titles = ("more time for the nearer hill", "the same time", "more time for the farther hill")
    for ax, share, title in zip(axes, (0.75, 0.5, 0.25), titles, strict=True):
        start = _Climbs(problem)
        path1 = start.climbed((30, 30), cells[0])
        left = problem.searcher.steps - len(path1) + 1
        path2 = start.climbed(cells[0], centre, round(share * left))
        path3 = start.climbed(cells[1], centre, left - round(share * left))
        path = [*path1, *path2[1:], *path3[::-1][1:]]
        lines = draw_path(ax, problem, path, title)
        for cell in cells:
            mark(ax, cell, "centroid")
        ax.plot(centre[1], centre[0], "s", ms=5, mfc="#1a9850", mec="white", zorder=6)
    figure.colorbar(lines, ax=axes, shrink=0.75, label="time step")
    return figure


class _Climbs:
    """Greedy legs one after the other, each over what the ones before have left."""

    def __init__(self, problem: SearchProblem) -> None:
        self.problem = problem
        self.looks = np.zeros(problem.grid.n_cells, np.int64)

    def climbed(self, start: tuple[int, int], end: tuple[int, int], steps: int | None = None) -> list[int]:
        """A leg of so many steps; None for as few as there can be."""
        grid = self.problem.grid
        least = int(grid.distances_from(grid.index(start))[grid.index(end)])
        leg = SearchProblem(grid, self.problem.gains.after(self.looks), (Searcher(start, steps or least, end),))
        path: list[int] = solve(leg, Greedy()).best.plan.actions[0].tolist()
        np.add.at(self.looks, path, 1)
        return path


def _hills(problem: SearchProblem, count: int) -> list[int]:
    """The best of five hills by Mode Goodness."""
    return [int(hill) for hill in ModeGoodness().ranked(directions(problem)[0], 5, np.random.default_rng(0))[:count]]


def figure_7(flown: Flown) -> Figure:
    """TopN: a path through the top four of five hills; a new colour from each hill on."""
    problem = flown.problem("upper left", 700)
    problem = replace(problem, searchers=(replace(problem.searcher, start=(40, 30), end=(30, 50)),))
    path = solve(problem, TopN(layers=((5, 4),))).best.plan.actions[0]
    hills = max(_hills_of_topn(problem), key=lambda found: len(set(found) & set(path.tolist())))
    cuts = [0, *sorted(int(np.argmax(path == hill)) for hill in hills), len(path) - 1]
    figure, (axes,) = panels(1, 1, 3.6, 3.4)
    draw_map(axes, surfaces(problem)[2], "TopN, k = 5 and N = 4", cmap="Greys", alpha=0.8)
    rows, cols = np.divmod(path, problem.grid.shape[1])
    for n, (begin, end) in enumerate(pairwise(cuts)):
        axes.plot(cols[begin : end + 1], rows[begin : end + 1], lw=1.2, color=f"C{n}")
    for letter, cut in zip("ABCD", cuts[1:-1], strict=False):
        mark(axes, (rows[cut], cols[cut]), "centroid")
        axes.annotate(letter, (cols[cut], rows[cut]), (4, 4), textcoords="offset points", weight="bold")
    mark(axes, (rows[0], cols[0]), "start")
    mark(axes, (rows[-1], cols[-1]), "end")
    return figure


def _hills_of_topn(problem: SearchProblem) -> list[list[int]]:
    """The four hills of a single layer of TopN, flown either way, under seed 0."""
    fields = directions(problem)
    found = []
    for field, rng in zip(fields, np.random.default_rng(0).spawn(len(fields)), strict=True):
        random_state(rng)  # drawn first, as the planner does
        found.append([int(hill) for hill in ModeGoodness().ranked(field, 5, rng)[:4]])
    return found


def figure_12(flown: Flown) -> Figure:
    """The author's five Gaussians, ranked by Mode Goodness Ratio."""
    import matplotlib.pyplot as plt

    ratios, gaussians = ratios_of_author(flown.data), author_gaussians(flown.data)
    rank = {int(n): r for r, n in enumerate(np.argsort(-np.asarray(ratios)), 1)}
    figure = plt.figure(figsize=(6.6, 3.1), layout="constrained")
    left, right = figure.add_subplot(1, 2, 1), figure.add_subplot(1, 2, 2, projection="3d")
    problem = flown.problem("HikerPaul")
    draw_map(left, surfaces(problem)[2], "Gaussians of the surface, 1, 2 and 3 σ", cmap="Greys", alpha=0.8)
    for n, gaussian in enumerate(gaussians):
        _ellipses(left, gaussian, f"{rank[n]}", plt.cm.viridis((rank[n] - 1) / 4.5))
        text = f"{rank[n]}: MGR {ratios[n]:.2f}"
        left.plot([], [], color=plt.cm.viridis((rank[n] - 1) / 4.5), label=text)
    mark(left, problem.searcher.start, "start")
    handles, labels = left.get_legend_handles_labels()
    order = np.argsort(labels)
    left.legend([handles[i] for i in order], [labels[i] for i in order], frameon=True, fontsize=6, loc="upper left")
    left.set(xlim=(-0.5, 99.5), ylim=(99.5, -0.5))
    rows, cols = np.mgrid[0:100:60j, 0:100:60j]
    right.plot_surface(cols, rows, 1e3 * _mixture(gaussians, rows, cols), cmap="viridis", lw=0, rcount=60, ccount=60)
    right.invert_yaxis()
    right.view_init(42, -62)
    right.set(xticks=[], yticks=[], zticks=[], title="the same in three dimensions")
    return figure


def _ellipses(axes: Axes, gaussian: Mapping[str, Any], text: str, colour: Any) -> None:
    turn = np.linspace(0, 2 * np.pi, 120)
    mean, root = np.array(gaussian["mean"]), np.linalg.cholesky(np.array(gaussian["cov"]))
    for sigmas in (1, 2, 3):
        rows, cols = mean[:, None] + sigmas * root @ np.vstack([np.cos(turn), np.sin(turn)])
        axes.plot(cols, rows, color=colour, lw=1.6 - 0.4 * sigmas)
    axes.text(mean[1], mean[0], text, color=colour, weight="bold", ha="center", va="center", fontsize=10)


def _mixture(gaussians: Sequence[Mapping[str, Any]], rows: Any, cols: Any) -> NDArray[np.float64]:
    total = np.zeros(rows.shape)
    for gaussian in gaussians:
        away = np.stack([rows, cols], axis=-1) - np.array(gaussian["mean"])
        cov = np.array(gaussian["cov"])
        power = np.einsum("...i,ij,...j", away, np.linalg.inv(cov), away)
        total += gaussian["weight"] * np.exp(-0.5 * power) / (2 * np.pi * np.sqrt(np.linalg.det(cov)))
    return total
