"""The figures of Wolek et al. 2020, drawn again. Figures 1 and 3 are sketches of the idea and are left out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.collections import LineCollection

from sooner.campaigns.run import Ran
from sooner.campaigns.study import Study
from sooner.experiments.figures import bare, draw_all, panels
from sooner.experiments.wolek2020.claims import AUTHORS, KRIGED, LAWNMOWER, RANDOM
from sooner.experiments.wolek2020.curves import Curves
from sooner.experiments.wolek2020.figures_of_flight import figure_5
from sooner.experiments.wolek2020.scenes import scene
from sooner.simulation import Estimator

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_figures"]

LINES = {RANDOM: ("random", "#7f7f7f"), LAWNMOWER: ("lawnmower", "#b35806"), KRIGED: ("information", "#2166ac")}


@dataclass(frozen=True)
class Source:
    """What figures are drawn from."""

    ran: Ran
    study: Study
    data: Path


def draw_figures(ran: Ran, study: Study, data: Path) -> Iterator[tuple[str, bytes]]:
    """Draw every figure: the name of a small PNG file, and what it holds."""
    yield from draw_all(FIGURES, Source(ran, study, data))


def figure_2(source: Source) -> Figure:
    """The three occupancy graphs."""
    figure, axes = panels(1, 3, 2.6, 2.7)
    for each, name in zip(axes, AUTHORS, strict=True):
        graph = scene(source.data, source.study.file.instances[name], Estimator()).world.graph
        each.add_collection(LineCollection(list(graph.positions_m[graph.edges]), colors="#1f3a5f", linewidths=0.8))
        each.plot(*graph.positions_m.T, ".", color="#1f3a5f", ms=2)
        each.set_aspect("equal")
        bare(each, f"{name}: {graph.n_nodes} nodes, {graph.n_edges} edges")
    figure.text(0.5, -0.03, "(c) OpenStreetMap contributors", ha="center", fontsize=7)
    return figure


def figure_4(source: Source) -> Figure:
    """Shares of nodes (mean and standard deviation) and of targets detected with time, cases 3, 4 and 6."""
    curves = Curves(source.ran)
    figure, (left, right) = panels(1, 2, 3.6, 2.8)
    for planner, (label, colour) in LINES.items():
        nodes = curves.nodes(planner, AUTHORS)
        mean, deviation = nodes.mean(axis=0), nodes.std(axis=0)
        left.plot(curves.times, 100 * mean, color=colour, label=label)
        left.fill_between(
            curves.times, 100 * (mean - deviation), 100 * (mean + deviation), color=colour, alpha=0.15, lw=0
        )
        right.plot(curves.times, 100 * curves.targets(planner, AUTHORS), color=colour, label=label)
    for axes, title in ((left, "(a) nodes detected, %: mean, deviation"), (right, "(b) targets detected, %")):
        _finish(axes, f"{title}, n = {len(curves.nodes(KRIGED, AUTHORS))}")
    return figure


def _finish(axes: Axes, title: str) -> None:
    axes.set(title=title, xlabel="share of the mission", xlim=(0, 1), ylim=(0, 100))
    axes.legend(frameon=False)


FIGURES: dict[int, Callable[[Source], Figure]] = {2: figure_2, 4: figure_4, 5: lambda _: figure_5()}
