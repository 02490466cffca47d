"""What the figures of Lin and Goodrich 2014 are made of: what was flown, its maps, and paths on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.campaigns.run import Ran
from sooner.campaigns.study import Study
from sooner.experiments.figures import draw_map, panels
from sooner.experiments.lin2014.maps import posed
from sooner.problem import Evaluation, Plan, SearchProblem, evaluate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Flown", "draw_difficulty", "draw_path", "draw_paths", "draw_three_maps", "mark", "surfaces"]


@dataclass(frozen=True)
class Flown:
    """What the figures draw from: the study, its maps and, of every case, the seed in the middle by value."""

    study: Study
    data: Path
    ran: Ran

    @cached_property
    def _middle(self) -> dict[tuple[str, str, int], tuple[int, ...]]:
        found = {}
        for case, _ in self.ran.asked.cases:
            answers = sorted(self.ran.answers(case), key=lambda each: float(each["efficiency"]))
            if answers and not case.alone:
                found[case.instance, case.planner, int(case.budget or 0)] = tuple(answers[len(answers) // 2]["cells"])
        return found

    def problem(self, instance: str, steps: int = 900) -> SearchProblem:
        """An instance of the study."""
        place = self.study.file.instances[instance]
        end = tuple(place["end"]) if "end" in place else None
        return posed(self.data, place["map"], tuple(place["start"]), steps, end)

    def judged(self, instance: str, planner: str, steps: int = 900) -> Evaluation:
        """The path of the seed in the middle, judged."""
        return evaluate(self.problem(instance, steps), Plan.of(self.cells(instance, planner, steps)))

    def cells(self, instance: str, planner: str, steps: int = 900) -> tuple[int, ...]:
        """The path of the seed in the middle."""
        return self._middle[instance, planner, steps]


def surfaces(problem: SearchProblem) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(H, W) each: probability, glimpse, and what a first visit collects."""
    collectible, glimpse = problem.gains.first, 1.0 - problem.gains.ratio
    shape = problem.grid.shape
    poc = collectible / glimpse
    return poc.reshape(shape), glimpse.reshape(shape), collectible.reshape(shape)


def draw_three_maps(problem: SearchProblem) -> Figure:
    """Probability, difficulty and their product, as in figures 2, 10, 13 and 15."""
    poc, glimpse, collectible = surfaces(problem)
    figure, (left, middle, right) = panels(1, 3, 2.9, 2.75)
    scale = {"vmin": 0.0, "vmax": 1e3 * float(poc.max())}
    shown = draw_map(left, 1e3 * poc, "probability of containment", **scale)
    figure.colorbar(shown, ax=left, shrink=0.75, label="per cell, × 10⁻³")
    draw_difficulty(figure, middle, glimpse, "task difficulty")
    shown = draw_map(right, 1e3 * collectible, "collectible on the first visit", **scale)
    figure.colorbar(shown, ax=right, shrink=0.75, label="per cell, × 10⁻³")
    for axes in (left, middle, right):
        mark(axes, problem.searcher.start, "start")
    return figure


def draw_difficulty(figure: Figure, axes: Axes, glimpse: NDArray[np.float64], title: str) -> None:
    """Classes of task difficulty, as far as the map has them."""
    from matplotlib.colors import ListedColormap

    levels = np.unique(glimpse)[::-1]
    classes = np.searchsorted(-levels, -glimpse)
    colours = ["#f2e8cf", "#a7c957", "#386641"][: len(levels)]
    shown = draw_map(axes, classes, title, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(levels) - 0.5)
    words = ["sparse", "medium", "dense"]
    bar = figure.colorbar(shown, ax=axes, shrink=0.75, ticks=range(len(levels)))
    bar.ax.set_yticklabels([f"{word}\ng = {level:.3g}" for word, level in zip(words, levels, strict=False)])


def mark(axes: Axes, cell: tuple[int, int], what: str) -> None:
    """A "start", an "end", or the "centroid" of a hill."""
    marker, colour = {"start": ("o", "#d73027"), "end": ("s", "#d73027"), "centroid": ("^", "#fdae61")}[what]
    axes.plot(cell[1], cell[0], marker, ms=5, mfc=colour, mec="white", mew=0.8, zorder=5)


def draw_path(axes: Axes, problem: SearchProblem, cells: Sequence[int], title: str, last: int | None = None) -> Any:
    """A path over what a first visit collects, coloured by time."""
    from matplotlib.collections import LineCollection

    draw_map(axes, surfaces(problem)[2], title, cmap="Greys", alpha=0.8)
    rows, cols = np.divmod(np.asarray(cells), problem.grid.shape[1])
    points = np.column_stack([cols, rows]).astype(float)
    lines = LineCollection(list(np.stack([points[:-1], points[1:]], axis=1)), cmap="plasma", linewidths=1.1)
    lines.set_array(np.arange(len(points) - 1))
    lines.set_clim(0, last or len(points) - 1)
    axes.add_collection(lines)
    mark(axes, (rows[0], cols[0]), "start")
    mark(axes, (rows[-1], cols[-1]), "end")
    return lines


def draw_paths(flown: Flown, drawn: Sequence[tuple[str, str, str]]) -> Figure:
    """Paths side by side: title, instance and planner of each."""
    figure, axes = panels(1, len(drawn), 2.6, 2.75)
    for ax, (title, instance, planner) in zip(axes, drawn, strict=True):
        problem, judged = flown.problem(instance), flown.judged(instance, planner)
        told = f"{title}\n{100 * (judged.efficiency or 0):.2f} %"
        lines = draw_path(ax, problem, flown.cells(instance, planner), told)
    figure.colorbar(lines, ax=axes, shrink=0.75, label="time step", ticks=range(0, 901, 300))
    return figure
