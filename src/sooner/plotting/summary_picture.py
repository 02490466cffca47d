"""The picture of a study: for each place every trial as a dot, and each planner's mean with its interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil
from textwrap import shorten
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sooner.plotting.png import png
from sooner.plotting.style import GREY, INK, PAPER, VALUE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Sample", "plot_summary"]

PLACES_MOST, PLANNERS_MOST, DOTS_MOST = 12, 16, 1000
ACROSS = 4  # panels beside each other
DOT = "#5f6c7b"
GOLDEN = 0.6180339887498949
HEAD, GAP = 0.8, 0.8  # inches: for the picture's title, and for a panel's title and axis
WIDE = {1: 6.5, 2: 4.2, 3: 3.2}  # inches of a panel, by how many are beside each other


@dataclass(frozen=True, eq=False)
class Sample:
    """What one planner's trials in one place came to.

    Parameters
    ----------
    planner : str
    values : (n,) float            of every trial that has the number; none where the planner has nothing to show
    mean, low, high : float        with its 95 % interval
    note : str                     then stands in place of the dots: that all trials failed
    """

    planner: str
    values: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    mean: float = np.nan
    low: float = np.nan
    high: float = np.nan
    note: str = ""


def plot_summary(
    title: str, measure: str, places: Mapping[str, Sequence[Sample]], yes_no: bool = False, note: str = ""
) -> bytes:
    """PNG: a panel for each place, in it a line for each planner, the first planner's mean as a thin line.

    Twelve places of sixteen planners at most are drawn, and a thousand evenly chosen trials of each; the picture says
    so where there are more.

    Parameters
    ----------
    title : str            of the study
    measure : str          whose numbers these are
    places : mapping       samples by the name of the place
    yes_no : bool          then the numbers are 0 and 1, and told as percent
    note : str             what the reader should know first, below the title
    """
    scale = 100.0 if yes_no else 1.0
    return png(lambda figure: _compose(figure, title, measure, dict(places), scale, note), dpi=130)


def _compose(
    figure: Figure, title: str, measure: str, places: Mapping[str, Sequence[Sample]], scale: float, note: str
) -> None:
    shown = {name: list(samples)[:PLANNERS_MOST] for name, samples in list(places.items())[:PLACES_MOST]}
    planners = [[sample.planner for sample in samples] for samples in shown.values()]
    same = all(names == planners[0] for names in planners)  # then names stand once, on the left
    columns = _columns(len(shown)) if same else min(_columns(len(shown)), 3)
    rows = ceil(len(shown) / columns)
    tall = 0.3 * max(map(len, planners)) + 0.15
    names = 0.075 * max(len(_name(name)) for some in planners for name in some) + 0.25
    wide, gap = WIDE.get(columns, 2.6), 0.35 if same else names + 0.2
    width = names + columns * wide + (columns - 1) * gap + 0.3
    head = HEAD + (0.22 if note else 0.0)
    height = head + rows * (tall + GAP)
    figure.set_size_inches(width, height)
    for number, (place, samples) in enumerate(shown.items()):
        row, column = divmod(number, columns)
        x = names + column * (wide + gap)
        y = height - head - row * (tall + GAP) - tall - 0.3
        axes = figure.add_axes((x / width, y / height, wide / width, tall / height))
        _draw(axes, place, samples, measure, scale, named=column == 0 or not same)
    _title(figure, title, measure if scale == 1.0 else f"{measure}, %", places, width, height)
    if note:
        told = shorten(note, int(width * 14), placeholder=" …")
        figure.text(0.15 / width, 1 - 0.77 / height, told, fontsize=8.5, color=INK, va="center")


def _columns(count: int) -> int:
    """Panels beside each other: as even a grid as there is.

    >>> [_columns(count) for count in (1, 2, 3, 4, 5, 6, 8, 9, 12)]
    [1, 2, 3, 2, 3, 3, 4, 3, 4]
    """
    rows = ceil(count / ACROSS) if count != 4 else 2
    return ceil(count / rows)


def _name(planner: str) -> str:
    return planner if len(planner) <= 34 else f"{planner[:33]}…"


def _draw(axes: Axes, place: str, samples: Sequence[Sample], measure: str, scale: float, named: bool) -> None:
    from matplotlib.ticker import MaxNLocator

    lines = np.arange(len(samples))
    if len(samples[0].values):
        axes.axvline(scale * samples[0].mean, color=VALUE, lw=0.8, alpha=0.55, zorder=1)
    for line, sample in zip(lines, samples, strict=True):
        if not len(sample.values):
            at = axes.get_yaxis_transform()
            axes.text(
                0.02, float(line), sample.note, transform=at, fontsize=8.5, style="italic", color=GREY, va="center"
            )
            continue
        values = sample.values[:: max(ceil(len(sample.values) / DOTS_MOST), 1)]
        off = 0.5 * ((np.arange(len(values)) * GOLDEN) % 1.0 - 0.5)
        faint = float(np.clip(6.0 / max(len(values), 1) ** 0.5, 0.08, 0.5))
        axes.scatter(scale * values, line + off, s=11, color=DOT, alpha=faint, lw=0, zorder=2)
        low, high = scale * sample.low, scale * sample.high
        axes.plot([low, high], [line, line], color=PAPER, lw=5.0, solid_capstyle="butt", zorder=3)
        axes.plot([low, high], [line, line], color=VALUE, lw=2.6, solid_capstyle="butt", zorder=4)
        axes.plot([scale * sample.mean], [line], "o", ms=5.0, mfc=VALUE, mec=PAPER, mew=0.9, zorder=5)
    axes.set_ylim(len(samples) - 0.4, -0.6)
    axes.set_yticks(lines, [_name(sample.planner) for sample in samples] if named else [""] * len(samples))
    axes.tick_params(axis="y", labelsize=9, length=0, pad=5, labelcolor=INK)
    axes.tick_params(axis="x", labelsize=8, length=0, pad=3)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 2.5, 5, 10]))
    axes.grid(axis="x", color="#e5e7eb", lw=0.7)
    axes.set_axisbelow(True)
    axes.margins(x=0.06)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.set_title(shorten(place, 44, placeholder=" …"), fontsize=9.5, loc="left", color=INK, pad=6)


def _title(
    figure: Figure, title: str, measure: str, places: Mapping[str, Sequence[Sample]], width: float, height: float
) -> None:
    most = int(width * 8.5)
    told = shorten(" ".join(title.split()), most, placeholder=" …")
    figure.text(0.15 / width, 1 - 0.3 / height, told, fontsize=13, color=INK, va="center", weight="bold")
    figure.text(0.15 / width, 1 - 0.55 / height, _explained(measure, places), fontsize=8.5, color=GREY, va="center")


def _explained(measure: str, places: Mapping[str, Sequence[Sample]]) -> str:
    parts = [f"{measure}: dots are trials, bars the mean and its 95 % interval, the line the first planner's mean"]
    if len(places) > PLACES_MOST:
        parts.append(f"the first {PLACES_MOST} of {len(places)} places")
    if (most := max(map(len, places.values()))) > PLANNERS_MOST:
        parts.append(f"the first {PLANNERS_MOST} of {most} planners")
    return "; ".join(parts)
