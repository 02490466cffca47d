"""The figures of Lin and Goodrich 2014, drawn again from what the study ran.

Figures 6 and 8 are pseudo-code; figure 9 is satellite imagery that is not at hand, so its vegetation classes, the
task difficulty map, are drawn instead.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.campaigns.run import Ran
from sooner.campaigns.study import Study
from sooner.experiments.lin2014.claims import author_gaussians, ratios_of_author
from sooner.experiments.lin2014.maps import posed
from sooner.planners import Greedy, Planner, max_ticks, solve
from sooner.planners.anneal import Anneal
from sooner.planners.global_warming import GlobalWarming
from sooner.planners.hill_climb import directions, random_state
from sooner.planners.mode_goodness import ModeGoodness
from sooner.planners.top2 import Top2
from sooner.planners.topn import TopN
from sooner.problem import Evaluation, Plan, Searcher, SearchProblem, evaluate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_figures"]

STYLE: Any = {
    "font.size": 8,
    "axes.titlesize": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.dpi": 140,
    "savefig.dpi": 140,
    "image.cmap": "YlGnBu",
}
NAMES = {"BA": "BA", "LHC-GW-CONV": "LHC-GW-CONV", "Top2": "Top2 (Hierarchy)", "TopN": "TopN (Hierarchy)"}
CURVES = {"TopN": ("black", "-"), "Top2": ("#2166ac", "--"), "LHC-GW-CONV": ("#b35806", "--"), "BA": ("#7f7f7f", "-.")}


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


def draw_figures(ran: Ran, study: Study, data: Path) -> Iterator[tuple[str, bytes]]:
    """Draw every figure that the data allow: the name of a small PNG file, and what it holds."""
    import matplotlib as mpl

    mpl.use("agg")
    flown = Flown(study, data, ran)
    for number, draw in FIGURES.items():
        with mpl.rc_context(STYLE):
            yield f"figure-{number:02d}.png", _drawn(draw(flown))


def _drawn(figure: Figure) -> bytes:
    import matplotlib.pyplot as plt

    drawn = io.BytesIO()
    options = {"optimize": True, "compress_level": 9}
    figure.savefig(drawn, format="png", bbox_inches="tight", metadata={"Software": None}, pil_kwargs=options)
    plt.close(figure)
    return drawn.getvalue()


def _panels(count: int, width: float = 2.6, height: float = 2.75) -> tuple[Figure, list[Axes]]:
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, count, figsize=(width * count, height), layout="constrained", squeeze=False)
    return figure, list(axes[0])


def _bare(axes: Axes, title: str) -> None:
    axes.set(title=title, xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(True)
        spine.set_linewidth(0.6)


def _map(axes: Axes, values: NDArray[Any], title: str, **settings: Any) -> Any:
    shown = axes.imshow(values, interpolation="nearest", **settings)
    _bare(axes, title)
    return shown


def _surfaces(problem: SearchProblem) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """(H, W) each: probability, glimpse, and what a first visit collects."""
    collectible, glimpse = problem.gains.first, 1.0 - problem.gains.ratio
    shape = problem.grid.shape
    poc = collectible / glimpse
    return poc.reshape(shape), glimpse.reshape(shape), collectible.reshape(shape)


def _three_maps(problem: SearchProblem) -> Figure:
    """Probability, difficulty and their product, as in figures 2, 10, 13 and 15."""
    poc, glimpse, collectible = _surfaces(problem)
    figure, (left, middle, right) = _panels(3, 2.9)
    scale = {"vmin": 0.0, "vmax": 1e3 * float(poc.max())}
    shown = _map(left, 1e3 * poc, "probability of containment", **scale)
    figure.colorbar(shown, ax=left, shrink=0.75, label="per cell, × 10⁻³")
    _difficulty(figure, middle, glimpse, "task difficulty")
    shown = _map(right, 1e3 * collectible, "collectible on the first visit", **scale)
    figure.colorbar(shown, ax=right, shrink=0.75, label="per cell, × 10⁻³")
    for axes in (left, middle, right):
        _mark(axes, problem.searcher.start, "start")
    return figure


def _difficulty(figure: Figure, axes: Axes, glimpse: NDArray[np.float64], title: str) -> None:
    from matplotlib.colors import ListedColormap

    levels = np.unique(glimpse)[::-1]
    classes = np.searchsorted(-levels, -glimpse)
    colours = ["#f2e8cf", "#a7c957", "#386641"][: len(levels)]
    shown = _map(axes, classes, title, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(levels) - 0.5)
    words = ["sparse", "medium", "dense"]
    bar = figure.colorbar(shown, ax=axes, shrink=0.75, ticks=range(len(levels)))
    bar.ax.set_yticklabels([f"{word}\ng = {level:.3g}" for word, level in zip(words, levels, strict=False)])


def _mark(axes: Axes, cell: tuple[int, int], what: str) -> None:
    marker, colour = {"start": ("o", "#d73027"), "end": ("s", "#d73027"), "centroid": ("^", "#fdae61")}[what]
    axes.plot(cell[1], cell[0], marker, ms=5, mfc=colour, mec="white", mew=0.8, zorder=5)


def _path(axes: Axes, problem: SearchProblem, cells: Sequence[int], title: str, last: int | None = None) -> Any:
    """A path over what a first visit collects, coloured by time."""
    from matplotlib.collections import LineCollection

    _map(axes, _surfaces(problem)[2], title, cmap="Greys", alpha=0.8)
    rows, cols = np.divmod(np.asarray(cells), problem.grid.shape[1])
    points = np.column_stack([cols, rows]).astype(float)
    lines = LineCollection(list(np.stack([points[:-1], points[1:]], axis=1)), cmap="plasma", linewidths=1.1)
    lines.set_array(np.arange(len(points) - 1))
    lines.set_clim(0, last or len(points) - 1)
    axes.add_collection(lines)
    _mark(axes, (rows[0], cols[0]), "start")
    _mark(axes, (rows[-1], cols[-1]), "end")
    return lines


def _paths(flown: Flown, drawn: Sequence[tuple[str, str, str]]) -> Figure:
    """Paths side by side: title, instance and planner of each."""
    figure, axes = _panels(len(drawn))
    for ax, (title, instance, planner) in zip(axes, drawn, strict=True):
        problem, judged = flown.problem(instance), flown.judged(instance, planner)
        lines = _path(ax, problem, flown.cells(instance, planner), f"{title}\n{100 * (judged.efficiency or 0):.2f} %")
    figure.colorbar(lines, ax=axes, shrink=0.75, label="time step", ticks=range(0, 901, 300))
    return figure


def figure_1(flown: Flown) -> Figure:
    """Two measures of a path, most by a time or soonest to a CDP: each is won by another path."""
    figure, (axes,) = _panels(1, 4.2, 2.9)
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


def figure_2(flown: Flown) -> Figure:
    """The synthetic scenario."""
    return _three_maps(flown.problem("upper left"))


def figure_3(flown: Flown) -> Figure:
    """BA and LHC-GW-CONV from the upper left."""
    return _paths(flown, [(name, "upper left", name) for name in ("BA", "LHC-GW-CONV")])


def figure_4(flown: Flown) -> Figure:
    """BA and LHC-GW-CONV from the lower right."""
    return _paths(flown, [(name, "lower right", name) for name in ("BA", "LHC-GW-CONV")])


def figure_5(flown: Flown) -> Figure:
    """Top2: the time shared out between two hills in three ways; both climb to the point halfway between them."""
    problem = posed(flown.data, "simple_bimodalfar_diff1", (30, 30), 450)
    hills = _hills(problem, 2)
    near, far = sorted(hills, key=lambda hill: int(problem.grid.distances_from(problem.grid.index((30, 30)))[hill]))
    cells = [problem.grid.cell(hill) for hill in (near, far)]
    centre = (sum(cell[0] for cell in cells) // 2, sum(cell[1] for cell in cells) // 2)
    figure, axes = _panels(3)
    titles = ("more time for the nearer hill", "the same time", "more time for the farther hill")
    for ax, share, title in zip(axes, (0.75, 0.5, 0.25), titles, strict=True):
        start = _Climbs(problem)
        path1 = start.climbed((30, 30), cells[0])
        left = problem.searcher.steps - len(path1) + 1
        path2 = start.climbed(cells[0], centre, round(share * left))
        path3 = start.climbed(cells[1], centre, left - round(share * left))
        path = [*path1, *path2[1:], *path3[::-1][1:]]
        lines = _path(ax, problem, path, title)
        for cell in cells:
            _mark(ax, cell, "centroid")
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
    figure, (axes,) = _panels(1, 3.6, 3.4)
    _map(axes, _surfaces(problem)[2], "TopN, k = 5 and N = 4", cmap="Greys", alpha=0.8)
    rows, cols = np.divmod(path, problem.grid.shape[1])
    for n, (begin, end) in enumerate(pairwise(cuts)):
        axes.plot(cols[begin : end + 1], rows[begin : end + 1], lw=1.2, color=f"C{n}")
    for letter, cut in zip("ABCD", cuts[1:-1], strict=False):
        _mark(axes, (rows[cut], cols[cut]), "centroid")
        axes.annotate(letter, (cols[cut], rows[cut]), (4, 4), textcoords="offset points", weight="bold")
    _mark(axes, (rows[0], cols[0]), "start")
    _mark(axes, (rows[-1], cols[-1]), "end")
    return figure


def _hills_of_topn(problem: SearchProblem) -> list[list[int]]:
    """The four hills of a single layer of TopN, flown either way, under seed 0."""
    fields = directions(problem)
    found = []
    for field, rng in zip(fields, np.random.default_rng(0).spawn(len(fields)), strict=True):
        random_state(rng)  # drawn first, as the planner does
        found.append([int(hill) for hill in ModeGoodness().ranked(field, 5, rng)[:4]])
    return found


def figure_9(flown: Flown) -> Figure:
    """Vegetation at Grayson Highlands, from the difficulty map: the satellite image is not at hand."""
    figure, (axes,) = _panels(1, 3.4, 2.9)
    problem = flown.problem("HikerPaul")
    _difficulty(figure, axes, _surfaces(problem)[1], "HikerPaul: vegetation, LKP at the centre")
    _mark(axes, problem.searcher.start, "start")
    return figure


def _scenario(name: str) -> Callable[[Flown], Figure]:
    return lambda flown: _three_maps(flown.problem(name))


def _four(name: str) -> Callable[[Flown], Figure]:
    return lambda flown: _paths(
        flown, [(f"{letter}) {short}", name, full) for letter, (short, full) in zip("abcd", NAMES.items(), strict=True)]
    )


def figure_12(flown: Flown) -> Figure:
    """The author's five Gaussians, ranked by Mode Goodness Ratio."""
    import matplotlib.pyplot as plt

    ratios, gaussians = ratios_of_author(flown.data), author_gaussians(flown.data)
    rank = {int(n): r for r, n in enumerate(np.argsort(-np.asarray(ratios)), 1)}
    figure = plt.figure(figsize=(6.6, 3.1), layout="constrained")
    left, right = figure.add_subplot(1, 2, 1), figure.add_subplot(1, 2, 2, projection="3d")
    problem = flown.problem("HikerPaul")
    _map(left, _surfaces(problem)[2], "Gaussians of the surface, 1, 2 and 3 σ", cmap="Greys", alpha=0.8)
    for n, gaussian in enumerate(gaussians):
        _ellipses(left, gaussian, f"{rank[n]}", plt.cm.viridis((rank[n] - 1) / 4.5))
        text = f"{rank[n]}: MGR {ratios[n]:.2f}"
        left.plot([], [], color=plt.cm.viridis((rank[n] - 1) / 4.5), label=text)
    _mark(left, problem.searcher.start, "start")
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


def figure_17(flown: Flown) -> Figure:
    """CDP over time on NewYork53."""
    figure, (axes,) = _panels(1, 4.4, 3.0)
    teleport = flown.problem("NewYork53").teleport.curve
    axes.plot(teleport, color="#d73027", ls=":", label="teleport")
    for name, (colour, line) in CURVES.items():
        judged = flown.judged("NewYork53", NAMES[name])
        label = f"{name} ({100 * (judged.efficiency or 0):.1f} %)"
        axes.plot(judged.times, judged.cdp, color=colour, ls=line, label=label)
    axes.set(xlabel="time step", ylabel="cumulative detection probability", xlim=(0, 900), ylim=(0, None))
    axes.legend(frameon=False)
    return figure


def figure_18(flown: Flown) -> Figure:
    """LHC-GW-CONV from the lower right, without and with an end."""
    return _paths(
        flown,
        [("no end", "lower right", "LHC-GW-CONV"), ("end at the upper left", "end at upper left", "LHC-GW-CONV")],
    )


FIGURES: dict[int, Callable[[Flown], Figure]] = {
    1: figure_1,
    2: figure_2,
    3: figure_3,
    4: figure_4,
    5: figure_5,
    7: figure_7,
    9: figure_9,
    10: _scenario("HikerPaul"),
    11: _four("HikerPaul"),
    12: figure_12,
    13: _scenario("NewYork53"),
    14: _four("NewYork53"),
    15: _scenario("NewYork108"),
    16: _four("NewYork108"),
    17: figure_17,
    18: figure_18,
}
