"""The figures of Kuhlman et al. 2017, drawn again: 4 to 7 from the environments, 8 to 21 from what the study flew.

Figures 1 to 3 are diagrams of the paper and of its argument.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.campaigns.results import Results
from sooner.campaigns.run import Ran
from sooner.campaigns.study import Study
from sooner.campaigns.trial import Case
from sooner.experiments.figures import draw_all, draw_map, panels
from sooner.experiments.kuhlman2017.claims import KINDS, sizes
from sooner.experiments.kuhlman2017.figures_of_ground import (
    figure_4,
    figure_5,
    figure_6,
    figure_7,
    figure_15,
    with_obstacles,
)
from sooner.experiments.kuhlman2017.ground import posed
from sooner.scenarios.natural import EXPERIMENT_2_CELLS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

__all__ = ["draw_figures"]

PLANNERS = ("eps-B&B", "greedy", "DFS", "DF-B&B")
COLOURS = {"eps-B&B": "black", "greedy": "#b35806", "DFS": "#2166ac", "DF-B&B": "#7f7f7f"}
ALPHAS = {"0.2": "#c6dbef", "0.7": "#6baed6", "0.8": "#2171b5", "0.9": "#08306b"}
ETAS = ("0", "0.5", "1", "2", "3")
PRINTED_FINAL = {  # eps-B&B, DFS, greedy and DF-B&B in Tables 2 and 3, in the order of KINDS
    "uniform": {"eps-B&B": (99.1, 98.5, 98.2, 98.0), "DFS": (97, 97, 97, 96), "greedy": (85, 81, 82, 84),
                "DF-B&B": (78.1, 71.2, 65.5, 64.6)},
    "nonuniform": {"eps-B&B": (98.6, 98.7, 98.1, 97.8), "DFS": (95, 96, 96, 95), "greedy": (83, 79, 80, 81),
                   "DF-B&B": (77.3, 68.2, 64.6, 64.7)},
}  # fmt: skip
PRINTED_EFFORT = {
    "uniform": {"eps-B&B": (1.4, 1.36, 1.31, 1.27), "DFS": (1.48, 1.40, 1.35, 1.30),
                "greedy": (1.61, 1.61, 1.56, 1.47), "DF-B&B": (1.72, 1.75, 1.80, 1.77)},
    "nonuniform": {"eps-B&B": (1.21, 1.27, 1.23, 1.20), "DFS": (1.25, 1.26, 1.24, 1.20),
                   "greedy": (1.34, 1.41, 1.35, 1.31), "DF-B&B": (1.4, 1.43, 1.45, 1.42)},
}  # fmt: skip
MOST = 6  # looks that have a colour of their own


@dataclass(frozen=True)
class Flown:
    """What the figures draw from."""

    study: Study
    ran: Ran

    @cached_property
    def cases(self) -> dict[tuple[str, str], Case]:
        """By instance and planner."""
        return {(case.instance, case.planner): case for case, _ in self.ran.asked.cases}

    @cached_property
    def results(self) -> dict[tuple[str, str], Results]:
        """By instance and planner."""
        return {(case.instance, case.planner): found for case, found in self.ran.results().items()}

    def measured(self, instance: str, planner: str, measure: str) -> NDArray[np.float64]:
        """The numbers of the trials that have one."""
        values = self.results[instance, planner].measure(measure)
        return np.asarray(values[~np.isnan(values)])

    def middle(self, instance: str, planner: str) -> tuple[int, list[int], float]:
        """Seed, actions and info of the trial in the middle by info."""
        found = self.results[instance, planner]
        answers = self.ran.answers(self.cases[instance, planner])
        ranked = sorted(
            (answer["info"], int(seed), answer["actions"])
            for seed, answer in zip(found.seeds, answers, strict=True)
            if answer["success"]
        )
        info, seed, actions = ranked[len(ranked) // 2]
        return seed, actions, info


def draw_figures(ran: Ran, study: Study, data: Path) -> Iterator[tuple[str, bytes]]:
    """Draw figures 4 to 21: the name of a small PNG file, and what it holds."""
    yield from draw_all(FIGURES, Flown(study, ran))


def figure_8(flown: Flown) -> Figure:
    """Experiment 1: nodes expanded, information, success."""
    figure, axes = panels(1, 3, 2.5, 2.4)
    told = (("expanded", "nodes expanded"), ("info", "information, % of reference"), ("success_percent", "success, %"))
    for ax, (measure, label) in zip(axes, told, strict=True):
        for alpha, colour in ALPHAS.items():
            means = [
                float(flown.measured("low uniform", f"alpha {alpha}, eta {eta} %", measure).mean()) for eta in ETAS
            ]
            ax.plot([float(eta) for eta in ETAS], means, "o-", ms=3, lw=1.2, color=colour, label=f"α = {alpha}")
        ax.set(xlabel="η, %", ylabel=label)
    axes[0].legend(frameon=False)
    axes[0].set_ylim(0, None)
    axes[2].set_ylim(-5, 105)
    return figure


def figure_9(flown: Flown) -> Figure:
    """Experiment 2 by number of cells."""
    planner = "eps-B&B, 10 environments"
    told = (
        ("regions", "a) regions"), ("t_max", "b) T_max, s"), ("expanded", "c) nodes expanded"),
        ("timing.first_s", "d) first solution, s"), ("timing.cpu_seconds", "e) whole search, s"),
        ("first_info", "f) first information, %"), ("info", "g) final information, %"),
        ("swept_m2_per_m", "h) swept, m² per m"),
    )  # fmt: skip
    figure, axes = panels(2, 4, 1.95, 1.9)
    for ax, (measure, label) in zip(axes, told, strict=True):
        _over_cells(ax, flown, "", planner, measure, "black")
        ax.set(title=label)
        if measure in ("regions", "t_max", "expanded", "timing.first_s", "timing.cpu_seconds"):
            ax.set_ylim(0, 1.1 * ax.get_ylim()[1])
    for ax in axes[4:]:
        ax.set(xlabel="cells")
    _over_cells(axes[6], flown, "wide ", planner, "info", "#b35806")
    _over_cells(axes[7], flown, "wide ", planner, "swept_m2_per_m", "#b35806")
    axes[7].plot([], [], color="black", label="centres in reach")
    axes[7].plot([], [], color="#b35806", label="any part in reach")
    axes[7].legend(frameon=False, fontsize=6)
    return figure


def figure_10(flown: Flown) -> Figure:
    """Information of DFS by number of cells."""
    figure, (axes,) = panels(1, 1, 3.4, 2.4)
    for prefix, colour, label in (("", "black", "centres in reach"), ("wide ", "#b35806", "any part in reach")):
        _over_cells(axes, flown, prefix, "DFS, 10 environments", "info", colour)
        axes.plot([], [], color=colour, label=label)
    axes.set(xlabel="cells", ylabel="information of DFS, % of reference", ylim=(94, 100))
    axes.legend(frameon=False, loc="upper right")
    return figure


def _over_cells(axes: Axes, flown: Flown, prefix: str, planner: str, measure: str, colour: str) -> None:
    """Mean and standard deviation."""
    found = [flown.measured(name, planner, measure) for name in sizes(prefix)]
    means, spread = [float(each.mean()) for each in found], [float(each.std()) for each in found]
    axes.errorbar(EXPERIMENT_2_CELLS, means, spread, fmt="o-", ms=3, lw=1.1, capsize=2, elinewidth=0.7, color=colour)
    axes.set_xscale("log")


def _plans(planner: str, prior: str) -> Callable[[Flown], Figure]:
    return lambda flown: _footprints(flown, planner, prior)


def _footprints(flown: Flown, planner: str, prior: str) -> Figure:
    """How often each cell is looked at, in the trial in the middle of each kind."""
    figure, axes = panels(2, 2, 3.0, 1.62)
    for ax, kind in zip(axes, KINDS, strict=True):
        name = f"{kind} {prior}"
        seed, actions, info = flown.middle(name, planner)
        found = posed(flown.study.file.instances[name], seed)
        shape = found.problem.grid.shape
        looks = np.minimum(found.looks(np.array(actions)), MOST).reshape(shape)
        shown = draw_map(
            ax, with_obstacles(looks, found.free.reshape(shape)), f"{kind}: {info:.1f} %", cmap=_looks_palette(),
            vmin=-0.5, vmax=MOST + 0.5,
        )  # fmt: skip
        row, col = found.problem.searcher.start
        ax.plot(col, row, "o", ms=4.5, mfc="#d73027", mec="white", mew=0.8)
    bar = figure.colorbar(shown, ax=axes, shrink=0.7, ticks=range(MOST + 1), label="looks")
    bar.ax.set_yticklabels([*map(str, range(MOST)), f"{MOST}+"])
    return figure


def _looks_palette() -> Colormap:
    import matplotlib as mpl
    from matplotlib.colors import ListedColormap

    blues = mpl.colormaps["Blues"]
    colours: list[Any] = ["white", *(blues(0.2 + 0.8 * look / MOST) for look in range(1, MOST + 1))]
    palette = ListedColormap(colours)
    palette.set_bad("black")
    return palette


def _bars(prior: str) -> Callable[[Flown], Figure]:
    return lambda flown: _summary(flown, prior)


def _summary(flown: Flown, prior: str) -> Figure:
    """Information, effort and time of the four planners; the paper's as open diamonds."""
    figure, axes = panels(1, 3, 2.7, 2.5)
    told = (("info", "information, % of reference"), ("effort", "effort, time constants"), ("timing.cpu_seconds", "s"))
    for ax, (measure, label) in zip(axes, told, strict=True):
        for number, planner in enumerate(PLANNERS):
            found = [flown.measured(f"{kind} {prior}", planner, measure) for kind in KINDS]
            places = np.arange(len(KINDS)) + 0.2 * (number - 1.5)
            means, spread = [float(each.mean()) for each in found], [float(each.std()) for each in found]
            error: Any = spread if measure != "timing.cpu_seconds" else None
            ax.bar(places, means, 0.18, yerr=error, color=COLOURS[planner], error_kw={"lw": 0.7}, label=planner)
            printed = {"info": PRINTED_FINAL, "effort": PRINTED_EFFORT}.get(measure)
            if printed:
                ax.plot(places, printed[prior][planner], "D", ms=3.2, mfc="white", mec="#d73027", mew=0.9, zorder=5)
        ax.set(xticks=range(len(KINDS)), xticklabels=KINDS, ylabel=label)
    axes[0].set_ylim(40, 102)
    axes[1].set_ylim(0.9, None)
    axes[2].set(yscale="log", ylabel="seconds of one core")
    axes[1].plot([], [], "D", ms=3.2, mfc="white", mec="#d73027", mew=0.9, label="published")
    figure.legend(*axes[1].get_legend_handles_labels(), loc="outside upper center", ncols=5, frameon=False)
    return figure


def _still(draw: Callable[[], Figure]) -> Callable[[Flown], Figure]:
    """A figure that needs no flight."""
    return lambda flown: draw()


FIGURES: dict[int, Callable[[Flown], Figure]] = {
    4: _still(figure_4),
    5: _still(figure_5),
    6: _still(figure_6),
    7: _still(figure_7),
    8: figure_8,
    9: figure_9,
    10: figure_10,
    **{11 + number: _plans(planner, "uniform") for number, planner in enumerate(PLANNERS)},
    15: _still(figure_15),
    **{16 + number: _plans(planner, "nonuniform") for number, planner in enumerate(PLANNERS)},
    20: _bars("uniform"),
    21: _bars("nonuniform"),
}
