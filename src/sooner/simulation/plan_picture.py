"""Pictures of a flown plan: what was believed and flown in each quarter, what was found and learnt, an animation."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sooner.belief import Belief
from sooner.errors import InvalidProblemError
from sooner.plotting.cells import CellMap
from sooner.plotting.flight import duration
from sooner.plotting.layers import Layer, painted, poc_layer, there_layer
from sooner.plotting.png import png
from sooner.plotting.style import BOUND, GREY, INK, VALUE
from sooner.simulation.picture import AGENTS, TARGET
from sooner.simulation.plan_episode import PlanEpisode

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["animated_plan", "plan_episode_picture"]

MOST_CELLS = 1_000_000  # that are drawn one by one; of more, the most in each block of cells
MOST_TARGETS = 300  # that are marked; more would hide the map
MOMENTS = 97  # at which the curve of what is learnt is worked out
FRAMES, MOST_FRAMES = 60, 1000
WIDE, MAP_WIDE = 13.0, 0.235


def plan_episode_picture(episode: PlanEpisode) -> bytes:
    """PNG: four maps, one for each quarter of the flight, above what was found and what was learnt by time.

    A map shows what was believed at the end of its quarter (as the picture of a plan shows what is there), the flights
    of the quarter, who is hidden (red +, pale once found), and what said yes in it (a square, grey where nobody is).
    """
    ends, cells = [episode.duration * quarter / 4 for quarter in range(5)], CellMap(episode.grid)
    tall = min(cells.tall, 2.0) * MAP_WIDE * WIDE
    height = tall + 2.9

    def compose(figure: Figure) -> None:
        peak = float(episode.model.theta.max())
        for quarter in range(4):
            axes = figure.add_axes((0.01 + 0.2475 * quarter, 2.5 / height, MAP_WIDE, tall / height))
            _draw_map(axes, episode, peak, ends[quarter], ends[quarter + 1])
            first, last = (duration(end, episode.flown.unit_s) for end in ends[quarter : quarter + 2])
            axes.set_title(f"{first} to {last}", fontsize=9.5, loc="left", color=INK)
        low, high = 0.55 / height, 1.35 / height
        _draw_found(figure.add_axes((0.045, low, 0.44, high)), episode)
        _draw_learnt(figure.add_axes((0.54, low, 0.44, high)), episode)

    return png(compose, (WIDE, height))


def animated_plan(episode: PlanEpisode, frames: int = FRAMES, frame_ms: int = 120, dpi: int = 70) -> bytes:
    """GIF: what is believed, so many times from start to end, with the flights since an eighth of the time before.

    Raises
    ------
    InvalidProblemError      if those are not 2 to 1000 frames
    """
    if not 2 <= frames <= MOST_FRAMES:
        raise InvalidProblemError(f"{frames} frames came; expected 2 to {MOST_FRAMES}")
    from PIL import Image

    times = np.linspace(0.0, episode.duration, frames).tolist()
    pictures = (Image.open(io.BytesIO(_frame(episode, time, dpi))) for time in times)
    drawn = [picture.convert("P", palette=Image.Palette.ADAPTIVE, colors=64) for picture in pictures]
    out = io.BytesIO()
    drawn[0].save(out, "GIF", save_all=True, append_images=drawn[1:], duration=frame_ms, loop=0, optimize=False)
    return out.getvalue()


def _frame(episode: PlanEpisode, time: float, dpi: int) -> bytes:
    tall = 4.8 * min(CellMap(episode.grid).tall, 2.0)

    def compose(figure: Figure) -> None:
        axes = figure.add_axes((0.02, 0.1 / (tall + 0.6), 0.96, tall / (tall + 0.6)))
        _draw_map(axes, episode, float(episode.model.theta.max()), max(time - episode.duration / 8, 0.0), time)
        told = duration(round(time), episode.flown.unit_s)
        if len(episode.there):
            told += f"   found {int((episode.found <= time).sum())} of {len(episode.there)}"
        alarms = int(episode.false[episode.answers.times <= time].sum())
        told += f"   false alarms {alarms}" if episode.model.false_alarm else ""
        axes.set_title(told, fontsize=10, loc="left", color=INK)

    return png(compose, (5.0, tall + 0.6), dpi)


def _draw_map(axes: Axes, episode: PlanEpisode, peak: float, first: float, last: float) -> None:
    """What is believed at the time `last`, and the flights since `first`."""
    theta = np.where(episode.grid.passable, episode.theta_at(last), 0.0)
    layer = poc_layer if isinstance(episode.model.known, Belief) else there_layer
    _draw_cells(axes, episode, layer(theta, peak))
    for number, course in enumerate(episode.courses):
        colour, way = AGENTS[number % len(AGENTS)], course.between(first, last)
        axes.plot(*way.T, color="white", lw=3.0, alpha=0.8, zorder=3, solid_capstyle="round")
        axes.plot(*way.T, color=colour, lw=1.5, zorder=4, solid_capstyle="round")
        axes.plot(*way[-1], "o", color=colour, ms=6, mec="white", mew=1.0, zorder=7)
    _draw_hidden(axes, episode, last)
    answers, centres = episode.answers, episode.grid.centres_m
    now = answers.yes & (answers.times > first) & (answers.times <= last)
    for chosen, colour in ((now & episode.false, GREY), (now & ~episode.false, TARGET)):
        east, north = centres[answers.cells[chosen]].T
        axes.scatter(east, north, s=60, marker="s", c="none", edgecolors=colour, linewidths=1.3, zorder=5)


def _draw_hidden(axes: Axes, episode: PlanEpisode, last: float) -> None:
    """Who is not found yet, and who is."""
    if len(episode.there) > MOST_TARGETS:
        return
    places, found = episode.grid.centres_m[episode.there], episode.found <= last
    for own, alpha in ((~found, 1.0), (found, 0.35)):
        east, north = places[own].T
        axes.scatter(east, north, s=90, marker="+", c=TARGET, linewidths=2.0, alpha=alpha, zorder=6)


def _draw_cells(axes: Axes, episode: PlanEpisode, layer: Layer) -> None:
    """Cells one by one; where they are too many, blocks of them by the most in each."""
    cells, (rows, cols) = CellMap(episode.grid), episode.grid.shape
    if episode.grid.n_cells <= MOST_CELLS:
        cells.draw_layer(axes, layer)
        return
    side = int(np.ceil(np.sqrt(episode.grid.n_cells / MOST_CELLS)))
    blocks = Layer(_most(layer.values.reshape(rows, cols), side), layer.colours, layer.norm, layer.ends)
    axes.imshow(painted(blocks, None), extent=cells.extent, interpolation="nearest", zorder=1)
    axes.set_xticks([])
    axes.set_yticks([])


def _most(values: NDArray[np.float64], side: int) -> NDArray[np.float64]:
    """The most in each block of so many rows and columns."""
    starts = [np.arange(0, length, side) for length in values.shape]
    return np.asarray(np.maximum.reduceat(np.maximum.reduceat(values, starts[0], axis=0), starts[1], axis=1))


def _draw_found(axes: Axes, episode: PlanEpisode) -> None:
    """How many of those who are there have been found by when, or looks that said yes where rates are learnt."""
    from matplotlib.ticker import MaxNLocator

    unit, times = _unit(episode), episode.answers.times
    if len(episode.there):
        when = np.sort(episode.found[np.isfinite(episode.found)])
        title = f"Found, of {len(episode.there)}"
    else:
        when, title = times[episode.answers.yes & ~episode.false], "Looks that said yes rightly"
    if episode.model.false_alarm:
        title += f"   (and {int(episode.false.sum())} false alarms: grey)"
    end = episode.duration
    steps = np.concatenate([[0.0], when, [end]]) * unit
    counts = np.concatenate([np.arange(len(when) + 1), [len(when)]])
    axes.fill_between(steps, counts, step="post", color=BOUND, alpha=0.12, lw=0)
    axes.step(steps, counts, where="post", color=BOUND, lw=2.0)
    axes.set_ylim(0, 1.08 * max(len(when), 1))
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    alarms = times[episode.false] * unit
    axes.plot(alarms, np.full(len(alarms), 0.03), "|", color=GREY, ms=6, transform=axes.get_xaxis_transform())
    _frame_curve(axes, episode, title)


def _draw_learnt(axes: Axes, episode: PlanEpisode) -> None:
    """How much less uncertain it is."""
    moments = np.linspace(0.0, episode.duration, MOMENTS)
    bits = episode.learnt_at(moments.tolist())
    axes.fill_between(moments * _unit(episode), bits, color=VALUE, alpha=0.12, lw=0)
    axes.plot(moments * _unit(episode), bits, color=VALUE, lw=2.0)
    what = "where the person is" if isinstance(episode.model.known, Belief) else "all cells"
    _frame_curve(axes, episode, f"Learnt of {what}, bits   ({bits[-1]:.2f})")


def _frame_curve(axes: Axes, episode: PlanEpisode, title: str) -> None:
    for quarter in range(1, 4):
        axes.axvline(episode.duration * _unit(episode) * quarter / 4, color="#e5e7eb", lw=0.8, zorder=0)
    axes.set_xlim(0, episode.duration * _unit(episode))
    axes.set_title(title, fontsize=9.5, loc="left", color=INK)
    told = "steps" if episode.flown.unit_s is None else "minutes"
    axes.set_xlabel(f"{told} into the flight", fontsize=8.5)
    axes.tick_params(labelsize=8, length=0)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)


def _unit(episode: PlanEpisode) -> float:
    """What times on curves count: minutes, or steps where nobody says how long they take."""
    return 1.0 if episode.flown.unit_s is None else episode.flown.unit_s / 60.0
