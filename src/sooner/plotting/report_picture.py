"""The pictures of a report: flights over the map, what they leave, how the value grows, and each flight by itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.plotting.cells import CellMap
from sooner.plotting.curves import draw_curve
from sooner.plotting.flight import draw_clock, draw_ends, draw_key, draw_legend, draw_path, draw_scale
from sooner.plotting.layers import Layer
from sooner.plotting.measure import Measure
from sooner.plotting.png import png
from sooner.plotting.style import END, INK, START
from sooner.problem import Evaluation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["MapView", "Square", "draw_flights", "draw_growth", "draw_left", "draw_one_flight"]

Floats = NDArray[np.float64]

WIDE, HIGH = 6.7, 6.4  # inches that a map may take
CLOCK, KEY, EDGE = 1.0, 0.5, 0.12  # beside a map, below it, and around it
MOST_NUMBERS = 24  # of waypoints; of more each fifth, tenth, ... is numbered
DPI = 115


@dataclass(frozen=True, eq=False)
class MapView:
    """A map, and what is drawn on it whatever it shows.

    Parameters
    ----------
    grid : Grid
    layer : Layer
    borders : of (n, 2) float       around where drones may be, metres
    scaled : bool                   whether metres are metres
    """

    grid: Grid
    layer: Layer
    borders: Sequence[Floats] = ()
    scaled: bool = True


@dataclass(frozen=True)
class Square:
    """A place with a letter: metres west, south, east, north of its edges."""

    letter: str
    edges: tuple[float, float, float, float]


def draw_flights(view: MapView, flights: Sequence[tuple[Floats, Floats]], label: str) -> bytes:
    """PNG: paths (n, 2) with their times (n,), in the unit that the label of the clock names."""
    last = max((float(times[-1]) for _, times in flights), default=0.0)

    def compose(axes: Axes) -> None:
        from matplotlib.colors import Normalize

        clock = Normalize(0, max(last, 1e-9))
        width = _width(axes, [path for path, _ in flights])
        for number, (path, times) in enumerate(flights):
            draw_path(axes, path, times, clock, width)
            draw_ends(axes, path, number if len(flights) > 1 else None)
        draw_legend(axes)
        draw_clock(axes, clock, label)

    return _map(view, compose, beside=CLOCK)


def draw_left(view: MapView, squares: Sequence[Square]) -> bytes:
    """PNG: what is left, with the richest places framed and lettered."""

    def compose(axes: Axes) -> None:
        from matplotlib.patches import Rectangle

        for square in squares:
            west, south, east, north = square.edges
            axes.add_patch(Rectangle((west, south), east - west, north - south, fill=False, ec=END, lw=1.8, zorder=6))
            box = {"facecolor": END, "edgecolor": "none", "pad": 1.8}
            axes.text(west, north, square.letter, color="white", fontsize=10, va="top", bbox=box, zorder=7)
        key = axes.inset_axes((0.0, -0.035, 0.3, 0.018))
        draw_key(key, view.layer)

    return _map(view, compose, below=KEY)


def draw_one_flight(view: MapView, path: Floats) -> bytes:
    """PNG: one flight in one colour with its waypoints numbered from 0, and the ground about it."""

    def compose(axes: Axes) -> None:
        _look_at(axes, path)
        axes.plot(*path.T, color="white", lw=3.4, alpha=0.9, zorder=4, solid_capstyle="round")
        axes.plot(*path.T, color=START, lw=1.5, zorder=5, solid_capstyle="round")
        draw_ends(axes, path, None)
        _draw_numbers(axes, path)
        draw_legend(axes)

    return _map(view, compose)


def draw_growth(evaluation: Evaluation, bound: float, step_s: float | None, measure: Measure) -> bytes:
    """PNG: how what is found grows, beside the bound."""
    return png(
        lambda figure: draw_curve(figure.add_axes((0.075, 0.17, 0.9, 0.7)), evaluation, bound, step_s, measure),
        (WIDE + CLOCK, 3.1),
        DPI,
    )


def _map(view: MapView, compose: Callable[[Axes], None], beside: float = EDGE, below: float = EDGE) -> bytes:
    """A map in a figure of its own shape, with so many inches beside and below it."""
    cells = CellMap(view.grid)
    tall = min(max(cells.tall, 0.12), 6.0)
    width = min(WIDE, HIGH / tall)
    height = width * tall
    size = (EDGE + width + beside, below + height + EDGE)

    def drawn(figure: Figure) -> None:
        axes = figure.add_axes((EDGE / size[0], below / size[1], width / size[0], height / size[1]))
        cells.draw_layer(axes, view.layer)
        _draw_borders(axes, view.borders)
        compose(axes)
        if view.scaled:
            draw_scale(axes)
        _draw_north(axes)

    return png(drawn, size, DPI)


def _width(axes: Axes, paths: Sequence[Floats]) -> float:
    """Of a line, points: thinner, the longer the way is."""
    flown = sum(float(np.hypot(*np.diff(path, axis=0).T).sum()) for path in paths)
    across = float(np.ptp(axes.get_xlim()) + np.ptp(axes.get_ylim()))
    return float(np.clip(60.0 * across / max(flown, 1e-9), 0.6, 2.6))


def _draw_borders(axes: Axes, borders: Sequence[Floats]) -> None:
    """Dashed, on a white halo, as they must be seen on dark ground too."""
    from matplotlib.collections import LineCollection

    if not borders:
        return
    axes.add_collection(LineCollection(list(borders), colors="white", linewidths=2.2, alpha=0.8, zorder=2.4))
    edge = LineCollection(list(borders), colors=END, linewidths=1.1, linestyles="dashed", zorder=2.5)
    edge.set_label("edge of where it may fly")
    axes.add_collection(edge)


def _look_at(axes: Axes, path: Floats) -> None:
    """The part of the map about a path, in the shape of the axes."""
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    low, high = path.min(axis=0), path.max(axis=0)
    share = max((high[0] - low[0]) / (east - west), (high[1] - low[1]) / (north - south), 0.1) * 1.16
    if share >= 1.0:
        return
    for limits, (least, most), middle in (
        (axes.set_xlim, (west, east), (low[0] + high[0]) / 2),
        (axes.set_ylim, (south, north), (low[1] + high[1]) / 2),
    ):
        half = share * (most - least) / 2
        middle = float(np.clip(middle, least + half, most - half))
        limits(middle - half, middle + half)


def _draw_numbers(axes: Axes, path: Floats) -> None:
    """Numbers beside waypoints, few enough to be read."""
    steps = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 10_000, 100_000)
    every = next((step for step in steps if len(path) / step <= MOST_NUMBERS), len(path))
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6}
    for number in range(every if every > 1 else 1, len(path) - 1, every):
        axes.plot(*path[number], "o", ms=3.5, color=START, zorder=6)
        axes.annotate(
            str(number), path[number], (4, 4), textcoords="offset points", fontsize=9.5, color=INK, bbox=box, zorder=7
        )


def _draw_north(axes: Axes) -> None:
    """An arrow in the lower left corner; rows of maps go from north to south."""
    axes.annotate(
        "N",
        (0.035, 0.115),
        (0.035, 0.03),
        xycoords="axes fraction",
        ha="center",
        fontsize=9,
        color=INK,
        arrowprops={"arrowstyle": "->", "color": INK, "lw": 1.3},
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
        zorder=9,
    )
