"""The picture of a plan: the flight over the map, and how the probability of having found the person grows."""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import shorten
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sooner.plotting.cells import CellMap
from sooner.plotting.curves import draw_curve
from sooner.plotting.flight import draw_clock, draw_ends, draw_key, draw_legend, draw_path, draw_scale, duration
from sooner.plotting.layers import Layer, glimpse_layer, looks_layer, time_layer
from sooner.plotting.measure import PROBABILITY, Measure
from sooner.plotting.png import png
from sooner.plotting.style import INK
from sooner.problem import Evaluation, Plan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Caption", "Row", "by", "draw_panels", "draw_plan", "draw_title", "png"]

WIDTH, HEIGHT = SIZE = 13.0, 7.4  # inches


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
    measure : Measure          what values count
    reference : float          what to compare with, over regions; nan where there is nothing
    reference_name : str
    """

    name: str = ""
    planner: str = ""
    bound: float = np.inf
    bound_proof: str = ""
    step_s: float | None = None
    cell_m: float | None = None
    measure: Measure = PROBABILITY
    reference: float = np.nan
    reference_name: str = ""


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
    poc : (H, W) float           where the person may be before the flight, or what else there is to collect
    glimpse : (H, W) float       P(detect in one look | there)
    caption : Caption
    """
    caption = caption or Caption()
    return png(lambda figure: _compose(figure, evaluation, plan, poc, glimpse, caption), SIZE)


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
    draw_curve(figure.add_axes((0.625, 0.49, 0.355, 0.34)), evaluation, caption.bound, caption.step_s, caption.measure)
    draw_panels(figure, cells, _panels(evaluation, plan, poc, glimpse, caption))


@dataclass(frozen=True)
class Row:
    """Where small maps stand side by side: the corner of the first, what each may take, and from one to the next."""

    left: float = 0.625
    top: float = 0.375
    widest: float = 0.111
    tallest: float = 0.27
    pitch: float = 0.122


def draw_panels(figure: Figure, cells: CellMap, panels: list[tuple[str, Layer]], row: Row = Row()) -> None:
    """Up to three small maps side by side, each with its key."""
    tall = cells.tall * WIDTH / HEIGHT  # of a panel that is as wide as its share of the figure
    wide = min(row.widest, row.tallest / tall)
    for number, (title, layer) in enumerate(panels):
        left = row.left + row.pitch * number
        axes = figure.add_axes((left, row.top - wide * tall, wide, wide * tall))
        cells.draw_layer(axes, layer)
        axes.set_title(title, fontsize=9, color=INK, loc="left", pad=5)
        draw_key(figure.add_axes((left, row.top - wide * tall - 0.026, max(wide, 0.06), 0.011)), layer)


def _panels(
    evaluation: Evaluation,
    plan: Plan,
    poc: NDArray[np.float64],
    glimpse: NDArray[np.float64] | None,
    caption: Caption,
) -> list[tuple[str, Layer]]:
    peak, measure = float(poc.max()), caption.measure
    minutes = caption.step_s / 60.0 if caption.step_s else 1.0
    first = first_looks(evaluation, plan) * minutes
    panels = []
    if evaluation.problem.drift is None:
        panels.append((measure.left, measure.layer(remaining(evaluation, poc), peak)))
    else:
        panels.append(("Before the flight", measure.layer(np.ravel(poc), peak)))
    panels.append(("First look, minutes" if caption.step_s else "First look, steps", time_layer(first)))
    if glimpse is not None and np.ptp(glimpse) > 0:
        panels.append(("One look detects, %", glimpse_layer(np.ravel(glimpse))))
    else:
        panels.append(("Looks at each cell", looks_layer(evaluation.looks)))
    return panels


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
    told = caption.measure.told
    second = [f"{told(evaluation.total)} {caption.measure.done} in {time}{by(caption)}"]
    if evaluation.problem.objective.target is None and np.isfinite(caption.bound):
        second.append(f"no flight can pass {told(caption.bound)}")
    if evaluation.efficiency is not None:
        second.append(f"{evaluation.efficiency:.1%} of what teleporting would {caption.measure.verb}")
    draw_title(figure, caption, second)


def by(caption: Caption) -> str:
    """Who planned it, as the end of a sentence."""
    return f", planned by {caption.planner}" if caption.planner else ""


def draw_title(figure: Figure, caption: Caption, second: list[str]) -> None:
    """The name of the mission, and a line of what was found below it."""
    figure.text(0.035, 0.945, shorten(caption.name, 90), fontsize=17, color=INK, weight="bold", va="center")
    figure.text(0.035, 0.895, "   ·   ".join(second), fontsize=11.5, color=INK, va="center")


def _draw_flight(
    axes: Axes, cells: CellMap, evaluation: Evaluation, plan: Plan, poc: NDArray[np.float64], caption: Caption
) -> None:
    from matplotlib.colors import Normalize

    cells.draw_layer(axes, caption.measure.layer(np.ravel(poc), float(poc.max())), numbered=True)
    longest = max(max(len(actions) for actions in plan.actions) - 1, 1)
    step = (caption.step_s or 60.0) / 60.0
    clock = Normalize(0, longest * step)
    points_a_cell = 450.0 / (float(np.ptp(axes.get_xlim())) / cells.grid.cell_m)
    width = float(np.clip(0.4 * points_a_cell, 0.7, 3.2))
    for number, actions in enumerate(plan.actions):
        path = cells.grid.centres_m[actions]
        draw_path(axes, path, np.arange(len(path), dtype=np.float64) * step, clock, width)
        draw_ends(axes, path, number if len(plan.actions) > 1 else None)
    draw_legend(axes)
    if caption.cell_m is not None:
        draw_scale(axes)
    draw_clock(axes, clock, "minutes into the flight" if caption.step_s else "steps into the flight")
