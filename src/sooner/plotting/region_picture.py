"""The picture of a plan over regions: the path over the ground, what it sees, and how the value grows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sooner.plotting.cells import CellMap
from sooner.plotting.curves import draw_curve
from sooner.plotting.flight import draw_team, duration
from sooner.plotting.layers import looks_layer, time_layer
from sooner.plotting.plan_picture import SIZE, Caption, Row, by, draw_panels, draw_title
from sooner.plotting.png import png
from sooner.plotting.style import GREY, INK
from sooner.problem import Evaluation, Plan, Searcher
from sooner.problem.regions import RegionMoves

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Ground", "draw_region_plan"]

WIDE = 0.7  # maps that are flatter have their small maps below them
MOST_NUMBERS = 60  # regions; of more nobody reads the numbers


@dataclass(frozen=True, eq=False)
class Ground:
    """What there is to collect in each cell, how often the plan looks there, and what it leaves.

    Parameters
    ----------
    there, left : (N,) float     before and after the plan
    looks : (N,) int
    """

    there: NDArray[np.float64]
    looks: NDArray[np.int64]
    left: NDArray[np.float64]


def draw_region_plan(evaluation: Evaluation, plan: Plan, ground: Ground, caption: Caption | None = None) -> bytes:
    """PNG of a plan over regions."""
    told = caption or Caption()
    return png(lambda figure: _compose(figure, evaluation, plan, ground, told), SIZE)


def _compose(figure: Figure, evaluation: Evaluation, plan: Plan, ground: Ground, caption: Caption) -> None:
    problem, measure = evaluation.problem, caption.measure
    cells, peak = CellMap(problem.grid), float(ground.there.max(initial=0.0))
    team = zip(problem.searchers, plan.actions, strict=True)
    flights = [_moves(searcher).timed(actions) for searcher, actions in team]
    longest = max(float(times[-1]) for _, times in flights)
    second = [f"{measure.told(evaluation.total)} {measure.done} in {duration(longest, 1.0)}{by(caption)}"]
    if np.isfinite(caption.bound):
        second.append(f"no flight over these regions passes {measure.told(caption.bound)}")
    reference = None
    if np.isfinite(caption.reference) and caption.reference > 0:
        reference = caption.reference, caption.reference_name
        second.append(f"{evaluation.total / caption.reference:.1%} of {caption.reference_name}")
    draw_title(figure, caption, second)
    wide = cells.tall < WIDE
    axes = figure.add_axes((0.045, 0.4, 0.475, 0.45) if wide else (0.045, 0.07, 0.475, 0.79))
    cells.draw_layer(axes, measure.layer(ground.there, peak), numbered=True)
    _draw_borders(axes, cells, _moves(problem.searchers[0]).graph.labels)
    draw_team(axes, flights, longest, caption.cell_m is not None)
    beside = figure.add_axes((0.64, 0.12, 0.34, 0.7) if wide else (0.625, 0.49, 0.355, 0.34))
    draw_curve(beside, evaluation, caption.bound, 1.0, measure, reference)
    panels = [
        (measure.left, measure.layer(ground.left, peak)),
        ("First look, minutes", time_layer(first_seen(evaluation, plan) / 60.0)),
        ("Looks at each cell", looks_layer(ground.looks)),
    ]
    draw_panels(figure, cells, panels, Row(0.045, 0.28, 0.15, 0.2, 0.165) if wide else Row())


def _draw_borders(axes: Axes, cells: CellMap, labels: NDArray[np.int32]) -> None:
    """Thin lines where one region meets another or ground of none, and the regions' numbers."""
    from matplotlib.collections import LineCollection

    west, _, _, north = cells.extent
    size = cells.grid.cell_m
    free = cells.grid.passable.reshape(cells.grid.shape)
    rows, cols = np.nonzero((labels[:, 1:] != labels[:, :-1]) & free[:, 1:] & free[:, :-1])
    upright = [((c + 1, r), (c + 1, r + 1)) for r, c in zip(rows, cols, strict=True)]
    rows, cols = np.nonzero((labels[1:] != labels[:-1]) & free[1:] & free[:-1])
    level = [((c, r + 1), (c + 1, r + 1)) for r, c in zip(rows, cols, strict=True)]
    lines = np.array(upright + level, np.float64).reshape(-1, 2, 2) * (size, -size) + (west, north)
    axes.add_collection(LineCollection(list(lines), colors=GREY, linewidths=0.8, zorder=2))
    count = int(labels.max(initial=-1)) + 1
    for region in range(count if count <= MOST_NUMBERS else 0):
        rows, cols = np.nonzero(labels == region)
        nearest = int(np.argmin((rows - rows.mean()) ** 2 + (cols - cols.mean()) ** 2))
        place = west + (cols[nearest] + 0.5) * size, north - (rows[nearest] + 0.5) * size
        box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8}
        axes.text(*place, str(region), fontsize=6.5, color=INK, ha="center", va="center", bbox=box, zorder=6)


def _moves(searcher: Searcher) -> RegionMoves:
    assert isinstance(searcher.moves, RegionMoves)
    return searcher.moves


def first_seen(evaluation: Evaluation, plan: Plan) -> NDArray[np.float64]:
    """(N,): seconds until the first look at each cell, NaN where there was none."""
    first = np.full(evaluation.problem.grid.n_cells, np.inf)
    for searcher, actions in zip(evaluation.problem.searchers, plan.actions, strict=True):
        moves = _moves(searcher)
        footprints = moves.graph.footprints
        for action, begun, turned in moves.flown(actions):
            entries = slice(footprints.starts[action], footprints.starts[action + 1])
            after = (footprints.back_s if turned else footprints.seconds)[entries]
            np.minimum.at(first, footprints.cells[entries], begun + after)
    return np.where(np.isfinite(first), first, np.nan)
