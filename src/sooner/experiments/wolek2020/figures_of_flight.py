"""Figure 5: the flight test, panels (a) to (h)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle
from numpy.typing import NDArray

from sooner.experiments.figures import bare, panels
from sooner.experiments.wolek2020.flight_test import Replan, flight_test, track_at
from sooner.simulation import Episode

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["figure_5"]

SEED = 0  # the first: nothing was chosen
AGENTS = ("#0072b2", "#e69f00", "#9467bd", "#d4b106")  # blue, orange, purple and yellow, as in the paper
DARK, HIDDEN, GREY = "#1f3a5f", "#8f959e", "#d6d9de"


def figure_5() -> Figure:
    """The flight test."""
    episode, replans = flight_test(SEED)
    figure, axes = panels(2, 4, 2.7, 2.75)
    for quarter in range(4):
        first, last = (round(episode.seconds * part / 4) for part in (quarter, quarter + 1))
        _draw_quarter(axes[quarter], episode, first, last)
        bare(axes[quarter], f"({'abcd'[quarter]}) {first} to {last} s")
    first_quarter = episode.seconds // 4
    _draw_tasks(axes[4], episode, [each for each in replans if each.second <= first_quarter][-1])
    _draw_track(axes[5], episode, first_quarter)
    _draw_nodes(axes[6], episode)
    _draw_likelihood(axes[7], episode)
    return figure


def _draw_quarter(axes: Axes, episode: Episode, first: int, last: int) -> None:
    """What is known at the second `last`: nodes by log likelihood of the target; and the flights since `first`."""
    graph, beliefs = episode.scene.world.graph, episode.beliefs
    if beliefs is None:
        raise ValueError("an episode without beliefs came; expected one that kept them")
    now = min(last, len(beliefs.seconds) - 1)
    _draw_ground(axes, episode, beliefs.explored[now])
    known = (episode.found_nodes >= 0) & (episode.found_nodes <= now)
    axes.plot(*graph.positions_m[~known].T, ".", color=HIDDEN, ms=2)
    axes.add_collection(
        LineCollection(list(graph.positions_m[graph.explored_edges(known)]), colors=DARK, linewidths=0.6)
    )
    occupied = np.clip(beliefs.occupied[now][graph.cells[known]], 1e-12, 1.0 - 1e-12)
    odds = np.log10(occupied / (1.0 - occupied))
    east, north = graph.positions_m[known].T
    axes.scatter(east, north, c=odds, s=7, cmap="viridis", vmin=-6, vmax=2, linewidths=0, zorder=3)
    for agent, colour in enumerate(AGENTS):
        path = episode.places_m[first : last + 1, agent]
        axes.plot(*path.T, color=colour, lw=1.3, zorder=4)
        radius = float(episode.scene.agents[agent].radius_m)
        axes.add_patch(Circle(tuple(path[-1]), radius, fill=False, ec=colour, lw=1.0, zorder=4))
    axes.plot(*graph.positions_m[episode.targets[last]].T, "+", color="#d62728", ms=9, mew=2, zorder=5)
    axes.set(xlim=_extent(episode)[:2], ylim=_extent(episode)[2:])


def _draw_tasks(axes: Axes, episode: Episode, replan: Replan) -> None:
    """Information, the Voronoi cells of the tasks, and the ways planned through them."""
    shape = episode.scene.grid.shape
    image = replan.information.reshape(shape)
    axes.imshow(image, extent=_extent(episode), cmap="YlGnBu", interpolation="nearest")
    axes.add_collection(LineCollection(_borders(episode, replan.owner), colors="#9aa0a8", linewidths=0.5))
    for place, route in zip(replan.places_m, replan.routes, strict=True):
        axes.plot(*np.vstack([place, route]).T, ".-", color="magenta", lw=1.2, ms=4)
    bare(axes, f"(e) information and tasks, {replan.second:.0f} s")


def _draw_track(axes: Axes, episode: Episode, second: int) -> None:
    """Target states, each between its two nodes and nearer to the present one, by log likelihood ratio."""
    track = track_at(episode, second)
    graph, explored = episode.scene.world.graph, track.explored
    places, states = track.states.graph.positions_m, track.states
    at = (places[states.previous[explored]] + 2.0 * places[states.current[explored]]) / 3.0
    known = (episode.found_nodes >= 0) & (episode.found_nodes <= second)
    axes.add_collection(
        LineCollection(list(graph.positions_m[graph.explored_edges(known)]), colors=GREY, linewidths=0.8)
    )
    ratios = track.log_ratios[explored] / np.log(10.0)
    axes.scatter(at[:, 0], at[:, 1], c=ratios, s=5, cmap="viridis", vmin=-6, vmax=2, linewidths=0)
    axes.set(xlim=_extent(episode)[:2], ylim=_extent(episode)[2:])
    axes.set_aspect("equal")
    bare(axes, f"(f) log10 likelihood of {int(explored.sum())} states, {second} s")


def _draw_nodes(axes: Axes, episode: Episode) -> None:
    axes.plot(100.0 * episode.nodes_curve, color=DARK)
    axes.set(title="(g) nodes detected, %", xlabel="s", xlim=(0, episode.seconds), ylim=(0, 103))


def _draw_likelihood(axes: Axes, episode: Episode) -> None:
    """The integrated likelihood ratio against its threshold."""
    axes.semilogy(np.clip(episode.sums, 1e-6, None), color=DARK)
    axes.axhline(episode.scene.estimator.odds, color="#d62728", lw=0.8, ls="--")
    axes.set(title="(h) integrated likelihood ratio", xlabel="s", xlim=(0, episode.seconds))


def _draw_ground(axes: Axes, episode: Episode, explored: NDArray[np.bool_]) -> None:
    image = np.where(explored, 1.0, 0.0).reshape(episode.scene.grid.shape)
    axes.imshow(image, extent=_extent(episode), cmap="gray", vmin=-5.0, vmax=1.0, interpolation="nearest")


def _extent(episode: Episode) -> tuple[float, float, float, float]:
    grid = episode.scene.grid
    (height, width), half = grid.shape, 0.5 * grid.cell_m
    return -half, width * grid.cell_m - half, -half, height * grid.cell_m - half


def _borders(episode: Episode, owner: NDArray[np.int64]) -> list[NDArray[np.float64]]:
    """Sides of cells with another owner beyond: segments (2, 2)."""
    grid = episode.scene.grid
    owners, half = owner.reshape(grid.shape), 0.5 * grid.cell_m
    centres = grid.centres_m.reshape(*grid.shape, 2)
    sides = []
    for down, right in ((0, 1), (1, 0)):
        here = owners[: grid.shape[0] - down, : grid.shape[1] - right]
        beyond = owners[down:, right:]
        for east, north in centres[: here.shape[0], : here.shape[1]][here != beyond]:
            if right:
                sides.append(np.array([[east + half, north - half], [east + half, north + half]]))
            else:
                sides.append(np.array([[east - half, north - half], [east + half, north - half]]))
    return sides
