"""Pictures of an episode: what was explored and flown in each quarter, how much was known when, and an animation."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.plotting.cells import CellMap
from sooner.plotting.png import png
from sooner.plotting.style import BOUND, GREY, INK, VALUE
from sooner.simulation.episode import Episode

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["animation_of", "frame_of", "picture_of"]

# after Okabe and Ito, and two more
AGENTS = (
    "#0072b2",
    "#e69f00",
    "#9467bd",
    "#009e73",
    "#56b4e9",
    "#cc79a7",
    "#8c564b",
    "#000000",
)
TARGET, UNEXPLORED, EXPLORED, HIDDEN, NODE = "#d62728", "#d6d9de", "#ffffff", "#aab0b9", "#1f3a5f"
MOST_FRAMES = 1000
LEAP = 3.0  # cells between one second and the next that nobody walks


def picture_of(episode: Episode) -> bytes:
    """PNG: four maps, one for each quarter of the mission, above the shares of nodes and of targets detected by time.

    A map shows the cells that nobody has seen (grey), the streets detected by the end of the quarter (dark) and not
    yet (pale), the agents' flights of that quarter with what they see at its end, and where the targets are (red +).
    It is laid out after [Wolek2020, Fig. 5].
    """

    def compose(figure: Figure) -> None:
        for quarter in range(4):
            first, last = (round(episode.seconds * part / 4) for part in (quarter, quarter + 1))
            axes = figure.add_axes((0.01 + 0.2475 * quarter, 0.42, 0.2375, 0.52))
            _draw_map(axes, episode, first, last)
            axes.set_title(f"{first} to {last} s", fontsize=9.5, loc="left", color=INK)
        nodes, targets = f"(E_nodes {episode.e_nodes:.3f})", f"(E_targ {episode.e_targets:.3f})"
        known = (episode.nodes_curve, VALUE, f"Nodes detected, %   {nodes}")
        found = (
            episode.targets_curve,
            BOUND,
            f"Targets detected, %   {targets if episode.n_targets else '(none there)'}",
        )
        for column, (curve, colour, title) in enumerate((known, found)):
            _draw_curve(figure.add_axes((0.045 + 0.495 * column, 0.09, 0.44, 0.25)), episode, curve, colour, title)

    return png(compose, (13.0, 6.2))


def animation_of(episode: Episode, every_s: int = 4, frame_ms: int = 120, dpi: int = 70) -> bytes:
    """GIF: the map, a frame every so many seconds, each with the flights of the half minute before it.

    Raises
    ------
    InvalidProblemError      if that makes no frames, or more than a thousand
    """
    if every_s < 1 or episode.seconds // every_s + 1 > MOST_FRAMES:
        raise InvalidProblemError(
            f"a frame every {every_s} s of {episode.seconds} s came; expected 1 to {MOST_FRAMES} frames"
        )
    from PIL import Image

    frames = [
        Image.open(io.BytesIO(frame_of(episode, second, dpi))).convert("P", palette=Image.Palette.ADAPTIVE, colors=64)
        for second in range(0, episode.seconds + 1, every_s)
    ]
    out = io.BytesIO()
    frames[0].save(out, "GIF", save_all=True, append_images=frames[1:], duration=frame_ms, loop=0, optimize=False)
    return out.getvalue()


def frame_of(episode: Episode, second: int, dpi: int = 70) -> bytes:
    """PNG: the map at a second, with the flights of the half minute before it; of later seconds nothing is asked."""

    def compose(figure: Figure) -> None:
        axes = figure.add_axes((0.02, 0.02, 0.96, 0.9))
        _draw_map(axes, episode, max(second - 30, 0), second)
        told = f"{second} s   nodes {episode.nodes_curve[second]:.0%}"
        if episode.n_targets:
            told += f"   targets {episode.targets_curve[second]:.0%}"
        axes.set_title(told, fontsize=10, loc="left", color=INK)

    return png(compose, (5.0, 5.4), dpi)


def _draw_map(axes: Axes, episode: Episode, first: int, last: int) -> None:
    """What is known at the second `last`, and the flights since `first`."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import ListedColormap, Normalize

    from sooner.plotting.layers import Layer

    graph = episode.scene.world.graph
    seen = _explored(episode, last).astype(float)
    cells = CellMap(graph.grid)
    cells.draw_layer(axes, Layer(seen, ListedColormap([UNEXPLORED, EXPLORED]), Normalize(0.0, 1.0), ("", "")))
    detected = (episode.found_nodes >= 0) & (episode.found_nodes <= last)
    for known, colour, size in ((~detected, HIDDEN, 1.5), (detected, NODE, 3.0)):
        east, north = graph.positions_m[known].T
        axes.scatter(east, north, s=size, color=colour, linewidths=0, zorder=2)
    ends = graph.positions_m[graph.explored_edges(detected)]
    axes.add_collection(LineCollection(list(ends), colors=NODE, linewidths=0.9, zorder=2))
    wrong = (episode.node_seconds >= 0) & (episode.node_seconds <= last) & (graph.node_of_cell < 0)
    east, north = graph.grid.centres_m[wrong].T
    axes.scatter(east, north, s=7, marker="x", color=NODE, linewidths=0.8, zorder=2)
    _draw_agents(axes, episode, first, last)
    places = graph.positions_m[episode.targets[last]]
    axes.plot(*places.T, "+", color=TARGET, ms=11, mew=2.2, zorder=6)
    _draw_calls(axes, episode, first, last)
    _draw_followed(axes, episode, first, last)
    axes.set_xticks([])
    axes.set_yticks([])


def _draw_agents(axes: Axes, episode: Episode, first: int, last: int) -> None:
    from matplotlib.patches import Circle

    for agent, radius in enumerate(episode.scene.sensing.radius_m.tolist()):
        colour = AGENTS[agent % len(AGENTS)]
        path = episode.places_m[first : last + 1, agent]
        axes.plot(*path.T, color=colour, lw=1.6, zorder=4, solid_capstyle="round")
        axes.plot(*path[-1], "o", color=colour, ms=5, mec="white", mew=0.8, zorder=5)
        axes.add_patch(Circle(tuple(path[-1]), radius, fill=False, ec=colour, lw=1.1, zorder=4))


def _draw_calls(axes: Axes, episode: Episode, first: int, last: int) -> None:
    """Where the detector said that a target is: a square, grey where none was near."""
    for call in episode.calls:
        if first <= call.second <= last:
            place = episode.scene.grid.centres_m[call.cell]
            axes.plot(*place, "s", mfc="none", mec=TARGET if call.target >= 0 else GREY, ms=11, mew=1.4, zorder=6)


def _draw_followed(axes: Axes, episode: Episode, first: int, last: int) -> None:
    """Where targets that were found were likeliest: dotted ways, and at the end of each the number of its call.

    A track that changes its mind leaps; a way has a gap there.
    """
    second, number, cell = episode.followed.T
    now, side = (second >= first) & (second <= last), float(episode.scene.grid.cell_m)
    for each in np.unique(number[now]).tolist():
        way = episode.scene.grid.centres_m[cell[now & (number == each)]]
        leaps = 1 + np.flatnonzero(np.hypot(*np.diff(way, axis=0).T) > LEAP * side)
        axes.plot(*np.insert(way, leaps, np.nan, axis=0).T, color=TARGET, lw=1.3, ls=":", zorder=6)
        axes.annotate(
            str(each), way[-1], (6, 5), textcoords="offset points", fontsize=9, color=TARGET, zorder=7, weight="bold"
        )


def _draw_curve(axes: Axes, episode: Episode, curve: NDArray[np.float64], colour: str, title: str) -> None:
    axes.fill_between(np.arange(len(curve)), 100.0 * curve, step="post", color=colour, alpha=0.12, lw=0)
    axes.step(np.arange(len(curve)), 100.0 * curve, where="post", color=colour, lw=2.0)
    for quarter in range(1, 4):
        axes.axvline(episode.seconds * quarter / 4, color="#e5e7eb", lw=0.8, zorder=0)
    axes.set_xlim(0, episode.seconds)
    axes.set_ylim(0, 104)
    axes.set_title(title, fontsize=9.5, loc="left", color=INK)
    axes.set_xlabel("seconds into the mission", fontsize=8.5)
    axes.tick_params(labelsize=8, length=0)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)


def _explored(episode: Episode, last: int) -> NDArray[np.bool_]:
    """(M,) bool: cells that came into view by a second."""
    centres = episode.scene.grid.centres_m
    seen = np.zeros(len(centres), bool)
    if episode.scene.estimator.prior == "known":
        return ~seen
    for agent, radius in enumerate(episode.scene.sensing.radius_m.tolist()):
        for place in episode.places_m[: last + 1, agent]:
            seen |= ((centres - place) ** 2).sum(axis=1) <= radius**2
    return seen
