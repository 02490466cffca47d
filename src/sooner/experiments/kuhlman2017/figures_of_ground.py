"""Figures 4 to 7 and 15 of Kuhlman et al. 2017: drawn from the environments, without a flight."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.belief import EvidenceGrid
from sooner.decomposition.plow import coverage_paths
from sooner.experiments.figures import draw_map, panels
from sooner.experiments.kuhlman2017.claims import KINDS
from sooner.experiments.kuhlman2017.ground import DETECT, FALSE_ALARM, environment, ground
from sooner.motion.kinematics import Dynamics
from sooner.motion.rounded import rounded
from sooner.motion.trajectory import Trajectory
from sooner.scenarios.natural import FREE_SHARE, NATURAL_KINDS
from sooner.scenarios.simplex_noise import elevation

if TYPE_CHECKING:
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

__all__ = ["figure_4", "figure_5", "figure_6", "figure_7", "figure_15", "with_obstacles"]

DRONE = Dynamics(2.0, 2.0)
PASTELS = ("#8dd3c7", "#ffed6f", "#bebada", "#fb8072", "#80b1d3", "#fdb462", "#b3de69", "#fccde5")


def figure_4() -> Figure:
    """One region's coverage path: with a stop at every corner, and with corners flown as arcs."""
    found = ground("low", 1)
    region = int(np.argmax(found.regions.sizes))
    grid = found.environment.grid
    path = min(coverage_paths(grid, found.regions, region, 8.8), key=DRONE.seconds)
    rows, cols = found.regions.box(region)
    figure, axes = panels(1, 2, 2.1, 3.6)
    titles = ("stops at every corner", "arcs between plow lines")
    for ax, flight, title in zip(axes, (Trajectory.through(path, DRONE), rounded(path, DRONE)), titles, strict=True):
        inside = found.regions.labels == region
        shown = np.where(found.environment.free, np.where(inside, 0.35, 0.0), 1.0)
        draw_map(ax, shown, f"{title}\n{flight.duration:.0f} s", cmap="Greys", vmin=0, vmax=1.25)
        _, places, speeds = flight.sample(0.25)
        pixels = _pixels(found.environment.grid.shape[0], grid.cell_m, places)
        points = ax.scatter(*pixels, c=speeds, s=3, cmap="plasma", vmin=0, vmax=2.0, lw=0)
        ax.set(xlim=(cols.start - 4, cols.stop + 3), ylim=(rows.stop + 3, rows.start - 4))
    figure.colorbar(points, ax=axes, shrink=0.75, label="speed, m/s")
    return figure


def _pixels(height: int, cell_m: float, places: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Column and row of places in metres east and north, for a map whose row 0 is north."""
    return places[:, 0] / cell_m, height - 1 - places[:, 1] / cell_m


def figure_5() -> Figure:
    """One band of noise, two bands as a map and in three dimensions, and the ground cut from them."""
    import matplotlib.pyplot as plt

    terrain = NATURAL_KINDS["med"]
    seed = environment("med", 1).seed
    one = elevation(terrain.shape, terrain.frequencies[:1], (1.0,), seed)
    both = elevation(terrain.shape, terrain.frequencies, terrain.weights, seed)
    figure = plt.figure(figsize=(6.4, 3.7), layout="constrained")
    top = [figure.add_subplot(2, 2, place) for place in (1, 2, 4)]
    draw_map(top[0], one, "a) one band of noise", cmap="Greys_r")
    draw_map(top[1], both, "b) two bands", cmap="terrain")
    draw_map(top[2], both > np.quantile(both, FREE_SHARE), "d) the highest third becomes obstacles", cmap="Greys")
    rows, cols = np.mgrid[0 : terrain.shape[0] : 2, 0 : terrain.shape[1] : 2]
    solid: Any = figure.add_subplot(2, 2, 3, projection="3d")
    solid.plot_surface(cols, rows, both[::2, ::2], cmap="terrain", lw=0, rcount=50, ccount=100)
    solid.set_box_aspect((2, 1, 0.35), zoom=1.5)
    solid.invert_yaxis()
    solid.view_init(50, -80)
    solid.set(xticks=[], yticks=[], zticks=[], title="c) the same in three dimensions")
    return figure


def figure_6() -> Figure:
    """The first environment of each kind, in regions."""
    from matplotlib.colors import ListedColormap

    figure, axes = panels(2, 2, 3.0, 1.72)
    for ax, kind in zip(axes, KINDS, strict=True):
        found = ground(kind, 1)
        labels, free = found.regions.labels, found.environment.free
        hues = _distinct(found.regions.adjacency, found.regions.n_regions)
        shown = np.where(labels >= 0, hues[labels] + 1, 0)
        palette = ListedColormap(["#f5f5f5", *PASTELS])
        palette.set_bad("black")
        title = f"{kind}: {found.regions.n_regions} regions"
        draw_map(ax, with_obstacles(shown, free), title, cmap=palette, vmin=-0.5, vmax=len(PASTELS) + 0.5)
        rows, cols = np.divmod(found.regions.centres, free.shape[1])
        ax.plot(cols, rows, "o", ms=1.8, color="#333333")
    return figure


def _distinct(adjacency: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """(R,): colours of which neighbours share none, the least used first."""
    hues, used = np.full(count, -1), np.zeros(len(PASTELS), np.int64)
    for region in range(count):
        near = hues[adjacency[(adjacency == region).any(axis=1)].ravel()]
        hue = min(range(len(PASTELS)), key=lambda each: (each in near, used[each]))
        hues[region] = hue
        used[hue] += 1
    return hues


def figure_7() -> Figure:
    """The sensor: cells in view answer yes (dark) or no, and are wrong 15 times in a hundred."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Circle

    rng = np.random.default_rng(7)
    rows, cols = np.mgrid[0:15, 0:15]
    seen = np.hypot(rows - 7, cols - 7) * 2.2 <= 8.8 + 1e-9
    there = rng.random(seen.shape) < 0.12
    hit = rng.random(seen.shape) < np.where(there, DETECT, FALSE_ALARM)
    figure, (axes,) = panels(1, 1, 2.9, 2.9)
    shown, colours = np.where(seen, np.where(hit, 2, 1), 0), ["white", "#d9d9d9", "#1a9850"]
    draw_map(axes, shown, "one look of radius 8.8 m", cmap=ListedColormap(colours), vmin=0, vmax=2)
    axes.set_xticks(np.arange(-0.5, 15), minor=True)
    axes.set_yticks(np.arange(-0.5, 15), minor=True)
    axes.grid(which="minor", color="#bbbbbb", lw=0.5)
    axes.tick_params(which="minor", length=0)
    axes.add_patch(Circle((7, 7), 4.0, fill=False, color="black", lw=1.0))
    axes.plot(7, 7, "k+", ms=6)
    axes.plot(*np.nonzero((there & seen).T), "x", ms=4, color="#d73027", label="target")
    axes.legend(loc="lower right", fontsize=6.5, handletextpad=0.2)
    return figure


def figure_15() -> Figure:
    """Entropy before the search."""
    figure, axes = panels(2, 2, 3.0, 1.72)
    for ax, kind in zip(axes, KINDS, strict=True):
        place = environment(kind, 1, nonuniform=True)
        bits = EvidenceGrid(place.theta).entropy
        shown = draw_map(ax, with_obstacles(bits, place.free), kind, cmap=_colours("Reds"), vmin=0, vmax=1.3)
    figure.colorbar(
        shown, ax=axes, shrink=0.6, label="bits a cell", boundaries=np.linspace(0, 1, 50), ticks=[0, 0.2, 1]
    )
    return figure


def with_obstacles(values: NDArray[Any], free: NDArray[np.bool_]) -> NDArray[Any]:
    """Values of free cells; obstacles are masked."""
    return np.ma.masked_array(values, ~free)


def _colours(name: str) -> Colormap:
    """A palette on which what is masked, obstacles, is black."""
    import matplotlib as mpl

    found: Colormap = mpl.colormaps[name].copy()
    found.set_bad("black")
    return found
