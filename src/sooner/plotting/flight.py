"""What every picture of a flight has: the path by time, where it starts and ends, keys, a clock and a scale."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.plotting.layers import Layer, flight_colours
from sooner.plotting.style import END, GREY, INK, START

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_clock", "draw_ends", "draw_key", "draw_legend", "draw_path", "draw_scale", "draw_team", "duration"]


def draw_team(
    axes: Axes, flights: list[tuple[NDArray[np.float64], NDArray[np.float64]]], longest: float, scaled: bool
) -> None:
    """Paths (n, 2) with the seconds at which each place is reached, their ends, and the clock and scale beside them."""
    from matplotlib.colors import Normalize

    clock = Normalize(0, max(longest / 60.0, 1e-9))
    flown_m = sum(float(np.hypot(*np.diff(path, axis=0).T).sum()) for path, _ in flights)
    across_m = float(np.ptp(axes.get_xlim()) + np.ptp(axes.get_ylim()))
    width = float(np.clip(60.0 * across_m / max(flown_m, 1e-9), 0.6, 2.6))
    for number, (path, times) in enumerate(flights):
        draw_path(axes, path, times / 60.0, clock, width)
        draw_ends(axes, path, number if len(flights) > 1 else None)
    draw_legend(axes)
    if scaled:
        draw_scale(axes)
    draw_clock(axes, clock, "minutes into the flight")


def draw_path(axes: Axes, path: NDArray[np.float64], times: NDArray[np.float64], clock: Any, width: float) -> None:
    """A path (n, 2) in the colours of the clock, each leg in that of its beginning, on a white halo."""
    from matplotlib.collections import LineCollection

    if len(path) < 2:
        return
    legs = list(np.stack([path[:-1], path[1:]], axis=1))
    halo = LineCollection(legs, colors="white", linewidths=width + 1.4, capstyle="round", zorder=4, alpha=0.85)
    line = LineCollection(legs, cmap=flight_colours(), norm=clock, linewidths=width, capstyle="round", zorder=5)
    line.set_array(times[:-1])
    axes.add_collection(halo)
    axes.add_collection(line)


def draw_ends(axes: Axes, path: NDArray[np.float64], number: int | None) -> None:
    """Where a flight starts and ends, with the searcher's number where there are several."""
    start, last = path[0], path[-1]
    home = np.allclose(start, last)
    if not home:
        axes.plot(*last, "s", ms=10, mfc=END, mec="white", mew=1.6, zorder=6, label="end")
    axes.plot(*start, "o", ms=11, mfc=START, mec="white", mew=1.8, zorder=7, label="start and end" if home else "start")
    if number is not None:
        axes.annotate(str(number), start, color="white", fontsize=7.5, ha="center", va="center_baseline", zorder=8)


def draw_legend(axes: Axes) -> None:
    """Each name once, in the upper left corner, or the right one where a flight starts in the left."""
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    marks = [line for line in axes.lines if str(line.get_label()).startswith("start")]
    starts = [np.asarray(mark.get_xydata(), np.float64)[0].tolist() for mark in marks]
    hidden = any(x < 0.75 * west + 0.25 * east and y > 0.2 * south + 0.8 * north for x, y in starts)
    seen = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    names = sorted(seen, reverse=True)
    legend = axes.legend(
        [seen[name] for name in names],
        names,
        loc="upper right" if hidden else "upper left",
        fontsize=9,
        framealpha=0.9,
        edgecolor="none",
        handletextpad=0.3,
    )
    legend.set_zorder(9)


def draw_clock(axes: Axes, clock: Any, label: str) -> None:
    """A bar beside the map that says when."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.ticker import MaxNLocator

    beside = axes.inset_axes((1.015, 0.0, 0.022, 1.0))
    colours = axes.figure.colorbar(ScalarMappable(clock, flight_colours()), cax=beside)
    colours.ax.yaxis.set_major_locator(MaxNLocator(steps=[1, 2, 5, 10], integer=True))
    colours.set_label(label, fontsize=9, color=INK)
    colours.outline.set_visible(False)
    colours.ax.tick_params(labelsize=8, length=0, colors=GREY)


def draw_key(axes: Axes, layer: Layer) -> None:
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


def draw_scale(axes: Axes) -> None:
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


def duration(steps: float, step_s: float | None) -> str:
    """As `30:00 min`, or in steps where nobody says how long one takes.

    >>> duration(900, 2.0), duration(900, None)
    ('30:00 min', '900 steps')
    """
    if step_s is None:
        return f"{steps:g} steps"
    minutes, seconds = divmod(round(steps * step_s), 60)
    return f"{minutes}:{seconds:02d} min"
