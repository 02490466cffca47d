"""The picture of a plan along legs: sorties over the map and its borders, what they leave, and how the value grows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from sooner.plotting.cells import CellMap
from sooner.plotting.curves import draw_curve
from sooner.plotting.flight import draw_team, duration
from sooner.plotting.layers import effort_layer, time_layer
from sooner.plotting.plan_picture import SIZE, Caption, Row, by, draw_panels, draw_title
from sooner.plotting.png import png
from sooner.plotting.region_picture import WIDE, Ground
from sooner.plotting.style import INK
from sooner.problem import Evaluation, Plan
from sooner.problem.leg_moves import LegMoves, places_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_leg_plan"]


def draw_leg_plan(evaluation: Evaluation, plan: Plan, ground: Ground, caption: Caption | None = None) -> bytes:
    """PNG of a plan along legs; `ground.looks` is effort."""
    told = caption or Caption()
    return png(lambda figure: _compose(figure, evaluation, plan, ground, told), SIZE)


def _compose(figure: Figure, evaluation: Evaluation, plan: Plan, ground: Ground, caption: Caption) -> None:
    problem, measure = evaluation.problem, caption.measure
    cells, peak = CellMap(problem.grid), float(ground.there.max(initial=0.0))
    moves = [each.moves for each in problem.searchers if isinstance(each.moves, LegMoves)]
    flights = [
        (places_of(actions), each.departs_s + each.flight(actions).times)
        for each, actions in zip(moves, plan.actions, strict=True)
    ]
    last = max(float(times[-1]) for _, times in flights)
    told = f"{len(flights)} sorties, all down after " if len(flights) > 1 else ""
    second = [f"{measure.told(evaluation.total)} {measure.done} in {told}{duration(last, 1.0)}{by(caption)}"]
    if np.isfinite(caption.bound):
        second.append(f"no flight can pass {measure.told(caption.bound)}")
    draw_title(figure, caption, second)
    wide = cells.tall < WIDE
    axes = figure.add_axes((0.045, 0.4, 0.475, 0.45) if wide else (0.045, 0.07, 0.475, 0.79))
    cells.draw_layer(axes, measure.layer(ground.there, peak), numbered=True)
    _draw_borders(axes, moves[0])
    draw_team(axes, flights, last, caption.cell_m is not None)
    beside = figure.add_axes((0.64, 0.12, 0.34, 0.7) if wide else (0.625, 0.49, 0.355, 0.34))
    draw_curve(beside, evaluation, caption.bound, 1.0, measure, None)
    panels = [
        (measure.left, measure.layer(ground.left, peak)),
        ("First in view, minutes", time_layer(_first_seen(evaluation, plan) / 60.0)),
        ("POD, %", effort_layer(ground.looks.astype(np.float64))),
    ]
    draw_panels(figure, cells, panels, Row(0.045, 0.28, 0.15, 0.2, 0.165) if wide else Row())


def _draw_borders(axes: Axes, moves: LegMoves) -> None:
    """The line around where drones may be, and around what they must stay out of."""
    from matplotlib.collections import LineCollection

    rings = [
        shapely.get_coordinates(ring)
        for part in shapely.get_parts(moves.airspace.free)
        for ring in (part.exterior, *part.interiors)
    ]
    axes.add_collection(LineCollection(rings, colors=INK, linewidths=0.7, linestyles="dashed", zorder=2.5))


def _first_seen(evaluation: Evaluation, plan: Plan) -> NDArray[np.float64]:
    """(N,): seconds until each cell is first in view, NaN where it never is."""
    problem = evaluation.problem
    first = np.full(problem.grid.n_cells, np.inf)
    for searcher, actions in zip(problem.searchers, plan.actions, strict=True):
        looks = searcher.moves.looks(problem.grid, searcher, actions)
        seen = looks.worth > 0 if looks.worth is not None else np.ones(len(looks.items), bool)
        np.minimum.at(first, looks.items[seen], looks.times[seen])
    return np.where(np.isfinite(first), first, np.nan)
