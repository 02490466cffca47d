"""The picture of a debrief: three maps side by side, or one below the other where they are wide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.plotting.cells import CellMap
from sooner.plotting.flight import draw_key, draw_scale
from sooner.plotting.layers import Layer, glimpse_layer, poc_layer
from sooner.plotting.png import png
from sooner.plotting.style import END, GREY, INK, START

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Maps", "draw_debrief"]

WIDE = 0.45  # maps that are flatter stand one below the other
LONGEST_TITLE = 90
HEAD = 0.85  # inches for the title
LEAST = 0.4  # inches of a map

Lines = Sequence[NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Maps:
    """What is drawn over cells.

    Parameters
    ----------
    before, after : (N,) float       probability of each cell
    pod : (N,) float
    missed : (N,) bool or None       cells that a plan would have looked at
    """

    before: NDArray[np.float64]
    pod: NDArray[np.float64]
    after: NDArray[np.float64]
    missed: NDArray[np.bool_] | None = None


def draw_debrief(grid: Grid, maps: Maps, flown: Lines, planned: Lines, name: str, told: str) -> bytes:
    """PNG of a debrief; lines are metres in the frame of `Grid.centres_m`."""
    cells = CellMap(grid)
    sheet = _Sheet.of(cells.tall)
    return png(lambda figure: _compose(figure, sheet, cells, maps, (flown, planned), (name, told)), sheet.size)


@dataclass(frozen=True)
class _Sheet:
    """Where three maps of one shape stand, in inches from the lower left corner.

    Parameters
    ----------
    size : (float, float)                  of the sheet
    corners : of (float, float)            of each map
    width, height : float                  of a map
    """

    size: tuple[float, float]
    corners: tuple[tuple[float, float], ...]
    width: float
    height: float

    @classmethod
    def of(cls, tall: float) -> _Sheet:
        """For maps so much taller than wide."""
        if tall < WIDE:
            height = max(9.2 * tall, LEAST)
            each = height + 0.85
            return cls((10.0, HEAD + 3 * each), tuple((0.4, 0.45 + k * each) for k in (2, 1, 0)), 9.2, height)
        width = 4.6 if tall <= 2.0 else max(9.2 / tall, LEAST)
        each = max(width, 2.9) + 0.35
        corners = tuple((0.4 + k * each, 0.45) for k in range(3))
        height = min(width * tall, 9.2)
        return cls((0.45 + 3 * each, HEAD + 0.85 + height), corners, width, height)

    def place(self, which: int) -> tuple[float, float, float, float]:
        """Of a map, as shares of the sheet."""
        (x, y), (wide, high) = self.corners[which], self.size
        return x / wide, y / high, self.width / wide, self.height / high


def _compose(
    figure: Figure, sheet: _Sheet, cells: CellMap, maps: Maps, lines: tuple[Lines, Lines], title: tuple[str, str]
) -> None:
    name, high = title[0], sheet.size[1]
    shown = name if len(name) <= LONGEST_TITLE else name[: LONGEST_TITLE - 1] + "…"
    figure.text(0.4 / sheet.size[0], 1 - 0.2 / high, shown, fontsize=15, weight="bold", va="top", color=INK)
    figure.text(0.4 / sheet.size[0], 1 - 0.52 / high, title[1], fontsize=10.5, va="top", color=GREY)
    peak = float(max(maps.before.max(initial=0.0), maps.after.max(initial=0.0)))
    scale = glimpse_layer(np.array([0.0, 1.0]))
    panels = [
        ("POC before, and what was flown", poc_layer(maps.before, peak)),
        ("POD, %", Layer(np.where(maps.pod > 0, maps.pod, np.nan), scale.colours, scale.norm, scale.ends)),
        ("POC after" + ("" if maps.missed is None else ", and gaps"), poc_layer(maps.after, peak)),
    ]
    for which, (heading, layer) in enumerate(panels):
        axes = figure.add_axes(sheet.place(which))
        cells.draw_layer(axes, layer)
        axes.set_title(heading, fontsize=10, loc="left", color=INK)
        draw_key(axes.inset_axes((0.0, -0.16 / sheet.height, 1.6 / sheet.width, 0.08 / sheet.height)), layer)
        if which == 0:
            _draw_lines(axes, *lines)
            draw_scale(axes)
        if which == 2 and maps.missed is not None:
            _draw_missed(axes, cells, maps.missed)


def _draw_lines(axes: Axes, flown: Lines, planned: Lines) -> None:
    from matplotlib.collections import LineCollection

    if planned:
        dashed = LineCollection(list(planned), colors=END, linewidths=1.0, linestyles="dashed", zorder=4)
        dashed.set_label("planned")
        axes.add_collection(dashed)
    flown = [line for line in flown if len(line) > 1]
    axes.add_collection(LineCollection(list(flown), colors="white", linewidths=2.6, alpha=0.8, zorder=5))
    line = LineCollection(list(flown), colors=START, linewidths=1.3, zorder=6)
    line.set_label("flown")
    axes.add_collection(line)
    axes.legend(loc="upper right", bbox_to_anchor=(1.0, 0.0), ncols=2, fontsize=8.5, frameon=False, borderaxespad=0.2)


def _draw_missed(axes: Axes, cells: CellMap, missed: NDArray[np.bool_]) -> None:
    """Gaps in a colour of their own, so thin that what is likely there shows."""
    from matplotlib.colors import to_rgba

    shown = np.zeros((*cells.grid.shape, 4))
    shown[missed.reshape(cells.grid.shape)] = to_rgba(END, 0.45)
    axes.imshow(shown, extent=cells.extent, interpolation="nearest", zorder=2)
