"""The picture of a plan: the flight over the map, and how the probability of having found the person grows."""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.plotting.cells import CellMap
from sooner.plotting.curves import draw_curve
from sooner.plotting.layers import Layer, flight_colours, glimpse_layer, looks_layer, poc_layer, time_layer
from sooner.plotting.style import END, GREY, INK, PAPER, START, STYLE
from sooner.problem import Evaluation, Plan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Caption", "draw_plan"]

WIDTH, HEIGHT = 13.0, 7.4  # inches


@dataclass(frozen=True)
class Caption:
    """What the picture says in words.

    Parameters
    ----------
    name : str                 of the mission
    planner : str
    bound : float              of the objective; inf while nothing is proved
    bound_proof : str
    step_s : float or None     seconds a step; None: time is told in steps
    cell_m : float or None     metres a cell; None: no scale bar
    """

    name: str = ""
    planner: str = ""
    bound: float = np.inf
    bound_proof: str = ""
    step_s: float | None = None
    cell_m: float | None = None


def draw_plan(
    evaluation: Evaluation,
    plan: Plan,
    poc: NDArray[np.float64],
    glimpse: NDArray[np.float64] | None = None,
    caption: Caption | None = None,
) -> bytes:
    """PNG of a plan.

    Parameters
    ----------
    evaluation : Evaluation      as the judge gives it
    plan : Plan                  of cell moves
    poc : (H, W) float           where the person may be before the flight
    glimpse : (H, W) float       P(detect in one look | there)
    caption : Caption
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    caption = caption or Caption()
    plain: dict[Any, Any] = dict(mpl.rcParamsDefault)
    with mpl.rc_context(plain | STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font")  # a name in a script that the font lacks
        figure = Figure(figsize=(WIDTH, HEIGHT), facecolor=PAPER, layout=None)
        FigureCanvasAgg(figure)
        _compose(figure, evaluation, plan, poc, glimpse, caption)
        drawn = io.BytesIO()
        figure.savefig(drawn, format="png", dpi=120, facecolor=PAPER, metadata={"Software": "sooner"})
    return drawn.getvalue()


def _compose(
    figure: Figure,
    evaluation: Evaluation,
    plan: Plan,
    poc: NDArray[np.float64],
    glimpse: NDArray[np.float64] | None,
    caption: Caption,
) -> None:
    _title(figure, evaluation, caption)
    cells = CellMap(evaluation.problem.grid)
    _draw_flight(figure.add_axes((0.045, 0.07, 0.475, 0.79)), cells, evaluation, plan, poc, caption)
    draw_curve(figure.add_axes((0.625, 0.49, 0.355, 0.34)), evaluation, caption.bound, caption.step_s)
    west, east, south, north = cells.extent
    tall = (north - south) / (east - west) * WIDTH / HEIGHT  # of a panel that is as wide as its share of the figure
    wide = min(0.111, 0.27 / tall)
    for number, (title, layer) in enumerate(_panels(evaluation, plan, poc, glimpse, caption)):
        left, top = 0.625 + 0.122 * number, 0.375
        axes = figure.add_axes((left, top - wide * tall, wide, wide * tall))
        cells.draw_layer(axes, layer)
        axes.set_title(title, fontsize=9, color=INK, loc="left", pad=5)
        _key(figure.add_axes((left, top - wide * tall - 0.026, max(wide, 0.06), 0.011)), layer)


def _panels(
    evaluation: Evaluation,
    plan: Plan,
    poc: NDArray[np.float64],
    glimpse: NDArray[np.float64] | None,
    caption: Caption,
) -> list[tuple[str, Layer]]:
    peak = float(poc.max())
    minutes = caption.step_s / 60.0 if caption.step_s else 1.0
    first = first_looks(evaluation, plan) * minutes
    panels = []
    if evaluation.problem.drift is None:
        panels.append(("Still unseen afterwards", poc_layer(remaining(evaluation, poc), peak)))
    else:
        panels.append(("Before the flight", poc_layer(np.ravel(poc), peak)))
    panels.append(("First look, minutes" if caption.step_s else "First look, steps", time_layer(first)))
    if glimpse is not None and np.ptp(glimpse) > 0:
        panels.append(("One look detects, %", glimpse_layer(np.ravel(glimpse))))
    else:
        panels.append(("Looks at each cell", looks_layer(evaluation.looks)))
    return panels


def _key(axes: Axes, layer: Layer) -> None:
    """A narrow bar that says what the colours of a panel mean."""
    low, high = layer.ends
    ramp = np.linspace(0.0, 1.0, 128)[None, :]
    axes.imshow(layer.colours(ramp), aspect="auto", extent=(0, 1, 0, 1))
    axes.set_xticks([0, 1], [low, high])
    first, last = axes.get_xticklabels()
    first.set_horizontalalignment("left")
    last.set_horizontalalignment("right")
    axes.set_yticks([])
    axes.tick_params(labelsize=7.5, length=0, pad=2)
    for spine in axes.spines.values():
        spine.set_visible(False)


def first_looks(evaluation: Evaluation, plan: Plan) -> NDArray[np.float64]:
    """(N,): step of the first look at each cell, NaN where there was none."""
    first = np.full(evaluation.problem.grid.n_cells, np.inf)
    for actions in plan.actions:
        np.minimum.at(first, actions, np.arange(len(actions), dtype=np.float64))
    return np.where(np.isfinite(first), first, np.nan)


def remaining(evaluation: Evaluation, poc: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,): probability that the person is in the cell and has not been detected, after all looks."""
    left = np.array(poc, np.float64).ravel()
    cells = np.flatnonzero(evaluation.looks)
    look = 0
    while cells.size:
        left[cells] -= evaluation.problem.gains.of(cells, np.full(cells.size, look))
        look += 1
        cells = cells[evaluation.looks[cells] > look]
    return np.maximum(left, 0.0)


def _title(figure: Figure, evaluation: Evaluation, caption: Caption) -> None:
    time = duration(float(evaluation.times[-1]), caption.step_s)
    by = f", planned by {caption.planner}" if caption.planner else ""
    figure.text(0.035, 0.945, shorten(caption.name, 90), fontsize=17, color=INK, weight="bold", va="center")
    told = [f"{evaluation.total:.1%} found in {time}{by}"]
    if evaluation.problem.objective.target is None and np.isfinite(caption.bound):
        told.append(f"no flight can pass {caption.bound:.1%}")
    if evaluation.efficiency is not None:
        told.append(f"{evaluation.efficiency:.1%} of what teleporting would find")
    figure.text(0.035, 0.895, "   ·   ".join(told), fontsize=11.5, color=INK, va="center")


def duration(steps: float, step_s: float | None) -> str:
    """As `30:00 min`, or in steps where nobody says how long one takes.

    >>> duration(900, 2.0), duration(900, None)
    ('30:00 min', '900 steps')
    """
    if step_s is None:
        return f"{steps:g} steps"
    minutes, seconds = divmod(round(steps * step_s), 60)
    return f"{minutes}:{seconds:02d} min"


def _draw_flight(
    axes: Axes, cells: CellMap, evaluation: Evaluation, plan: Plan, poc: NDArray[np.float64], caption: Caption
) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.ticker import MaxNLocator

    cells.draw_layer(axes, poc_layer(np.ravel(poc), float(poc.max())), numbered=True)
    longest = max(max(len(actions) for actions in plan.actions) - 1, 1)
    step = (caption.step_s or 60.0) / 60.0
    clock = Normalize(0, longest * step)
    for number, actions in enumerate(plan.actions):
        _draw_path(axes, cells, cells.grid.centres_m[actions], clock, step)
        start = cells.grid.centres_m[actions[0]]
        last = cells.grid.centres_m[actions[-1]]
        home = np.array_equal(start, last)
        if not home:
            axes.plot(*last, "s", ms=10, mfc=END, mec="white", mew=1.6, zorder=6, label="end")
        axes.plot(
            *start, "o", ms=11, mfc=START, mec="white", mew=1.8, zorder=7, label="start and end" if home else "start"
        )
        if len(plan.actions) > 1:
            axes.annotate(str(number), start, color="white", fontsize=7.5, ha="center", va="center_baseline", zorder=8)
    seen = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    names = sorted(seen, reverse=True)
    axes.legend(
        [seen[name] for name in names],
        names,
        loc="upper left",
        fontsize=9,
        framealpha=0.9,
        edgecolor="none",
        handletextpad=0.3,
    )
    if caption.cell_m is not None:
        _scale_bar(axes, cells, caption.cell_m)
    beside = axes.inset_axes((1.015, 0.0, 0.022, 1.0))
    colours = axes.figure.colorbar(ScalarMappable(clock, flight_colours()), cax=beside)
    colours.ax.yaxis.set_major_locator(MaxNLocator(steps=[1, 2, 5, 10], integer=True))
    colours.set_label("minutes into the flight" if caption.step_s else "steps into the flight", fontsize=9, color=INK)
    colours.outline.set_visible(False)
    colours.ax.tick_params(labelsize=8, length=0, colors=GREY)


def _draw_path(axes: Axes, cells: CellMap, path: NDArray[np.float64], clock: Any, step: float) -> None:
    from matplotlib.collections import LineCollection

    if len(path) < 2:
        return
    legs = np.stack([path[:-1], path[1:]], axis=1)
    points_a_cell = 450.0 / (float(np.ptp(axes.get_xlim())) / cells.grid.cell_m)
    width = float(np.clip(0.4 * points_a_cell, 0.7, 3.2))
    halo = LineCollection(list(legs), colors="white", linewidths=width + 1.4, capstyle="round", zorder=4, alpha=0.85)
    line = LineCollection(list(legs), cmap=flight_colours(), norm=clock, linewidths=width, capstyle="round", zorder=5)
    line.set_array(np.arange(len(legs)) * step)
    axes.add_collection(halo)
    axes.add_collection(line)


def _scale_bar(axes: Axes, cells: CellMap, cell_m: float) -> None:
    """A bar of a round number of metres, about a fifth of the map, in its lower right corner."""
    left, right = axes.get_xlim()
    low, high = axes.get_ylim()
    fifth = (right - left) / 5
    unit = 10.0 ** np.floor(np.log10(fifth))
    length = float(max(factor for factor in (1, 2, 5) if factor * unit <= fifth) * unit)
    label = f"{length / 1000:g} km" if length >= 1000 else f"{length:g} m"
    x, y = right - 0.03 * (right - left), low + 0.035 * (high - low)
    axes.plot([x - length, x], [y, y], color="white", lw=7, solid_capstyle="butt", zorder=8)
    axes.plot([x - length, x], [y, y], color=INK, lw=3, solid_capstyle="butt", zorder=9)
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5}
    axes.text(
        x - length / 2,
        y + 0.012 * (high - low),
        label,
        ha="center",
        va="bottom",
        fontsize=9,
        color=INK,
        bbox=box,
        zorder=8,
    )
