"""The figures of Kuhlman et al. 2017, drawn again: 4 to 7 from the environments, 8 to 21 from what the study flew.

Figures 1 to 3 are diagrams of the paper and of its argument.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.belief import EvidenceGrid
from sooner.campaigns.results import Results
from sooner.campaigns.run import Ran
from sooner.campaigns.study import Study
from sooner.campaigns.trial import Case
from sooner.decomposition.plow import coverage_paths
from sooner.experiments.kuhlman2017.claims import KINDS, sizes
from sooner.experiments.kuhlman2017.ground import DETECT, FALSE_ALARM, environment, ground, posed
from sooner.motion.kinematics import Dynamics
from sooner.motion.rounded import rounded
from sooner.motion.trajectory import Trajectory
from sooner.scenarios.natural import EXPERIMENT_2_CELLS, FREE_SHARE, NATURAL_KINDS
from sooner.scenarios.simplex_noise import elevation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

__all__ = ["draw_figures"]

STYLE: Any = {
    "font.size": 8,
    "axes.titlesize": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.dpi": 140,
    "savefig.dpi": 140,
    "image.cmap": "YlGnBu",
}
PLANNERS = ("eps-B&B", "greedy", "DFS", "DF-B&B")
COLOURS = {"eps-B&B": "black", "greedy": "#b35806", "DFS": "#2166ac", "DF-B&B": "#7f7f7f"}
ALPHAS = {"0.2": "#c6dbef", "0.7": "#6baed6", "0.8": "#2171b5", "0.9": "#08306b"}
ETAS = ("0", "0.5", "1", "2", "3")
PRINTED_FINAL = {  # eps-B&B, DFS, greedy and DF-B&B in Tables 2 and 3, in the order of KINDS
    "uniform": {"eps-B&B": (99.1, 98.5, 98.2, 98.0), "DFS": (97, 97, 97, 96), "greedy": (85, 81, 82, 84),
                "DF-B&B": (78.1, 71.2, 65.5, 64.6)},
    "nonuniform": {"eps-B&B": (98.6, 98.7, 98.1, 97.8), "DFS": (95, 96, 96, 95), "greedy": (83, 79, 80, 81),
                   "DF-B&B": (77.3, 68.2, 64.6, 64.7)},
}  # fmt: skip
PRINTED_EFFORT = {
    "uniform": {"eps-B&B": (1.4, 1.36, 1.31, 1.27), "DFS": (1.48, 1.40, 1.35, 1.30),
                "greedy": (1.61, 1.61, 1.56, 1.47), "DF-B&B": (1.72, 1.75, 1.80, 1.77)},
    "nonuniform": {"eps-B&B": (1.21, 1.27, 1.23, 1.20), "DFS": (1.25, 1.26, 1.24, 1.20),
                   "greedy": (1.34, 1.41, 1.35, 1.31), "DF-B&B": (1.4, 1.43, 1.45, 1.42)},
}  # fmt: skip
DRONE = Dynamics(2.0, 2.0)
MOST = 6  # looks that have a colour of their own


@dataclass(frozen=True)
class Flown:
    """What the figures draw from."""

    study: Study
    ran: Ran

    @cached_property
    def cases(self) -> dict[tuple[str, str], Case]:
        """By instance and planner."""
        return {(case.instance, case.planner): case for case, _ in self.ran.asked.cases}

    @cached_property
    def results(self) -> dict[tuple[str, str], Results]:
        """By instance and planner."""
        return {(case.instance, case.planner): found for case, found in self.ran.results().items()}

    def measured(self, instance: str, planner: str, measure: str) -> NDArray[np.float64]:
        """The numbers of the trials that have one."""
        values = self.results[instance, planner].measure(measure)
        return np.asarray(values[~np.isnan(values)])

    def middle(self, instance: str, planner: str) -> tuple[int, list[int], float]:
        """Seed, actions and info of the trial in the middle by info."""
        found = self.results[instance, planner]
        answers = self.ran.answers(self.cases[instance, planner])
        ranked = sorted(
            (answer["info"], int(seed), answer["actions"])
            for seed, answer in zip(found.seeds, answers, strict=True)
            if answer["success"]
        )
        info, seed, actions = ranked[len(ranked) // 2]
        return seed, actions, info


def draw_figures(ran: Ran, study: Study, data: Path) -> Iterator[tuple[str, bytes]]:
    """Draw figures 4 to 21: the name of a small PNG file, and what it holds."""
    import matplotlib as mpl

    mpl.use("agg")
    flown = Flown(study, ran)
    for number, draw in FIGURES.items():
        with mpl.rc_context(STYLE):
            yield f"figure-{number:02d}.png", _drawn(draw(flown))


def _drawn(figure: Figure) -> bytes:
    import matplotlib.pyplot as plt

    drawn = io.BytesIO()
    options = {"optimize": True, "compress_level": 9}
    figure.savefig(drawn, format="png", bbox_inches="tight", metadata={"Software": None}, pil_kwargs=options)
    plt.close(figure)
    return drawn.getvalue()


def _panels(rows: int, cols: int, width: float, height: float) -> tuple[Figure, list[Axes]]:
    import matplotlib.pyplot as plt

    size = (width * cols, height * rows)
    figure, axes = plt.subplots(rows, cols, figsize=size, layout="constrained", squeeze=False)
    return figure, list(axes.flat)


def _map(axes: Axes, values: NDArray[Any], title: str, **settings: Any) -> Any:
    shown = axes.imshow(values, interpolation="nearest", **settings)
    axes.set(title=title, xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(True)
        spine.set_linewidth(0.6)
    return shown


def _with_obstacles(values: NDArray[Any], free: NDArray[np.bool_]) -> NDArray[Any]:
    """Values of free cells; obstacles are masked."""
    return np.ma.masked_array(values, ~free)


def _colours(name: str) -> Colormap:
    """A palette on which what is masked, obstacles, is black."""
    import matplotlib as mpl

    found: Colormap = mpl.colormaps[name].copy()
    found.set_bad("black")
    return found


# From the environments -----------------------------------------------------------------------------------------------


def figure_4(flown: Flown) -> Figure:
    """One region's coverage path: with a stop at every corner, and with corners flown as arcs."""
    found = ground("low", 1)
    region = int(np.argmax(found.regions.sizes))
    grid = found.environment.grid
    path = min(coverage_paths(grid, found.regions, region, 8.8), key=DRONE.seconds)
    rows, cols = found.regions.box(region)
    figure, axes = _panels(1, 2, 2.1, 3.6)
    titles = ("stops at every corner", "arcs between plow lines")
    for ax, flight, title in zip(axes, (Trajectory.through(path, DRONE), rounded(path, DRONE)), titles, strict=True):
        inside = found.regions.labels == region
        shown = np.where(found.environment.free, np.where(inside, 0.35, 0.0), 1.0)
        _map(ax, shown, f"{title}\n{flight.duration:.0f} s", cmap="Greys", vmin=0, vmax=1.25)
        _, places, speeds = flight.sample(0.25)
        pixels = _pixels(found.environment.grid.shape[0], grid.cell_m, places)
        points = ax.scatter(*pixels, c=speeds, s=3, cmap="plasma", vmin=0, vmax=2.0, lw=0)
        ax.set(xlim=(cols.start - 4, cols.stop + 3), ylim=(rows.stop + 3, rows.start - 4))
    figure.colorbar(points, ax=axes, shrink=0.75, label="speed, m/s")
    return figure


def _pixels(height: int, cell_m: float, places: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Column and row of places in metres east and north, for a map whose row 0 is north."""
    return places[:, 0] / cell_m, height - 1 - places[:, 1] / cell_m


def figure_5(flown: Flown) -> Figure:
    """One band of noise, two bands as a map and in three dimensions, and the ground cut from them."""
    import matplotlib.pyplot as plt

    terrain = NATURAL_KINDS["med"]
    seed = environment("med", 1).seed
    one = elevation(terrain.shape, terrain.frequencies[:1], (1.0,), seed)
    both = elevation(terrain.shape, terrain.frequencies, terrain.weights, seed)
    figure = plt.figure(figsize=(6.4, 3.7), layout="constrained")
    top = [figure.add_subplot(2, 2, place) for place in (1, 2, 4)]
    _map(top[0], one, "a) one band of noise", cmap="Greys_r")
    _map(top[1], both, "b) two bands", cmap="terrain")
    _map(top[2], both > np.quantile(both, FREE_SHARE), "d) the highest third becomes obstacles", cmap="Greys")
    rows, cols = np.mgrid[0 : terrain.shape[0] : 2, 0 : terrain.shape[1] : 2]
    solid: Any = figure.add_subplot(2, 2, 3, projection="3d")
    solid.plot_surface(cols, rows, both[::2, ::2], cmap="terrain", lw=0, rcount=50, ccount=100)
    solid.set_box_aspect((2, 1, 0.35), zoom=1.5)
    solid.invert_yaxis()
    solid.view_init(50, -80)
    solid.set(xticks=[], yticks=[], zticks=[], title="c) the same in three dimensions")
    return figure


def figure_6(flown: Flown) -> Figure:
    """The first environment of each kind, in regions."""
    from matplotlib.colors import ListedColormap

    figure, axes = _panels(2, 2, 3.0, 1.72)
    for ax, kind in zip(axes, KINDS, strict=True):
        found = ground(kind, 1)
        labels, free = found.regions.labels, found.environment.free
        hues = _distinct(found.regions.adjacency, found.regions.n_regions)
        shown = np.where(labels >= 0, hues[labels] + 1, 0)
        palette = ListedColormap(["#f5f5f5", *PASTELS])
        palette.set_bad("black")
        title = f"{kind}: {found.regions.n_regions} regions"
        _map(ax, _with_obstacles(shown, free), title, cmap=palette, vmin=-0.5, vmax=len(PASTELS) + 0.5)
        rows, cols = np.divmod(found.regions.centres, free.shape[1])
        ax.plot(cols, rows, "o", ms=1.8, color="#333333")
    return figure


PASTELS = ("#8dd3c7", "#ffed6f", "#bebada", "#fb8072", "#80b1d3", "#fdb462", "#b3de69", "#fccde5")


def _distinct(adjacency: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """(R,): colours of which neighbours share none, the least used first."""
    hues, used = np.full(count, -1), np.zeros(len(PASTELS), np.int64)
    for region in range(count):
        near = hues[adjacency[(adjacency == region).any(axis=1)].ravel()]
        hue = min(range(len(PASTELS)), key=lambda each: (each in near, used[each]))
        hues[region] = hue
        used[hue] += 1
    return hues


def figure_7(flown: Flown) -> Figure:
    """The sensor: cells in view answer yes (dark) or no, and are wrong 15 times in a hundred."""
    rng = np.random.default_rng(7)
    rows, cols = np.mgrid[0:15, 0:15]
    seen = np.hypot(rows - 7, cols - 7) * 2.2 <= 8.8 + 1e-9
    there = rng.random(seen.shape) < 0.12
    hit = rng.random(seen.shape) < np.where(there, DETECT, FALSE_ALARM)
    figure, (axes,) = _panels(1, 1, 2.9, 2.9)
    shown = np.where(seen, np.where(hit, 2, 1), 0)
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Circle

    _map(axes, shown, "one look of radius 8.8 m", cmap=ListedColormap(["white", "#d9d9d9", "#1a9850"]), vmin=0, vmax=2)
    axes.set_xticks(np.arange(-0.5, 15), minor=True)
    axes.set_yticks(np.arange(-0.5, 15), minor=True)
    axes.grid(which="minor", color="#bbbbbb", lw=0.5)
    axes.tick_params(which="minor", length=0)
    axes.add_patch(Circle((7, 7), 4.0, fill=False, color="black", lw=1.0))
    axes.plot(7, 7, "k+", ms=6)
    axes.plot(*np.nonzero((there & seen).T), "x", ms=4, color="#d73027", label="target")
    axes.legend(loc="lower right", fontsize=6.5, handletextpad=0.2)
    return figure


def figure_15(flown: Flown) -> Figure:
    """Entropy before the search."""
    figure, axes = _panels(2, 2, 3.0, 1.72)
    for ax, kind in zip(axes, KINDS, strict=True):
        place = environment(kind, 1, nonuniform=True)
        bits = EvidenceGrid(place.theta).entropy
        shown = _map(ax, _with_obstacles(bits, place.free), kind, cmap=_colours("Reds"), vmin=0, vmax=1.3)
    figure.colorbar(
        shown, ax=axes, shrink=0.6, label="bits a cell", boundaries=np.linspace(0, 1, 50), ticks=[0, 0.2, 1]
    )
    return figure


# From what was flown -------------------------------------------------------------------------------------------------


def figure_8(flown: Flown) -> Figure:
    """Experiment 1: nodes expanded, information, success."""
    figure, axes = _panels(1, 3, 2.5, 2.4)
    told = (("expanded", "nodes expanded"), ("info", "information, % of reference"), ("success_percent", "success, %"))
    for ax, (measure, label) in zip(axes, told, strict=True):
        for alpha, colour in ALPHAS.items():
            means = [
                float(flown.measured("low uniform", f"alpha {alpha}, eta {eta} %", measure).mean()) for eta in ETAS
            ]
            ax.plot([float(eta) for eta in ETAS], means, "o-", ms=3, lw=1.2, color=colour, label=f"α = {alpha}")
        ax.set(xlabel="η, %", ylabel=label)
    axes[0].legend(frameon=False)
    axes[0].set_ylim(0, None)
    axes[2].set_ylim(-5, 105)
    return figure


def figure_9(flown: Flown) -> Figure:
    """Experiment 2 by number of cells."""
    planner = "eps-B&B, 10 environments"
    told = (
        ("regions", "a) regions"), ("t_max", "b) T_max, s"), ("expanded", "c) nodes expanded"),
        ("timing.first_s", "d) first solution, s"), ("timing.cpu_seconds", "e) whole search, s"),
        ("first_info", "f) first information, %"), ("info", "g) final information, %"),
        ("swept_m2_per_m", "h) swept, m² per m"),
    )  # fmt: skip
    figure, axes = _panels(2, 4, 1.95, 1.9)
    for ax, (measure, label) in zip(axes, told, strict=True):
        _over_cells(ax, flown, "", planner, measure, "black")
        ax.set(title=label)
        if measure in ("regions", "t_max", "expanded", "timing.first_s", "timing.cpu_seconds"):
            ax.set_ylim(0, 1.1 * ax.get_ylim()[1])
    for ax in axes[4:]:
        ax.set(xlabel="cells")
    _over_cells(axes[6], flown, "wide ", planner, "info", "#b35806")
    _over_cells(axes[7], flown, "wide ", planner, "swept_m2_per_m", "#b35806")
    axes[7].plot([], [], color="black", label="centres in reach")
    axes[7].plot([], [], color="#b35806", label="any part in reach")
    axes[7].legend(frameon=False, fontsize=6)
    return figure


def figure_10(flown: Flown) -> Figure:
    """Information of DFS by number of cells."""
    figure, (axes,) = _panels(1, 1, 3.4, 2.4)
    for prefix, colour, label in (("", "black", "centres in reach"), ("wide ", "#b35806", "any part in reach")):
        _over_cells(axes, flown, prefix, "DFS, 10 environments", "info", colour)
        axes.plot([], [], color=colour, label=label)
    axes.set(xlabel="cells", ylabel="information of DFS, % of reference", ylim=(94, 100))
    axes.legend(frameon=False, loc="lower right")
    return figure


def _over_cells(axes: Axes, flown: Flown, prefix: str, planner: str, measure: str, colour: str) -> None:
    """Mean and standard deviation."""
    found = [flown.measured(name, planner, measure) for name in sizes(prefix)]
    means, spread = [float(each.mean()) for each in found], [float(each.std()) for each in found]
    axes.errorbar(EXPERIMENT_2_CELLS, means, spread, fmt="o-", ms=3, lw=1.1, capsize=2, elinewidth=0.7, color=colour)
    axes.set_xscale("log")


def _plans(planner: str, prior: str) -> Callable[[Flown], Figure]:
    return lambda flown: _footprints(flown, planner, prior)


def _footprints(flown: Flown, planner: str, prior: str) -> Figure:
    """How often each cell is looked at, in the trial in the middle of each kind."""
    figure, axes = _panels(2, 2, 3.0, 1.62)
    for ax, kind in zip(axes, KINDS, strict=True):
        name = f"{kind} {prior}"
        seed, actions, info = flown.middle(name, planner)
        found = posed(flown.study.file.instances[name], seed)
        shape = found.problem.grid.shape
        looks = np.minimum(found.looks(np.array(actions)), MOST).reshape(shape)
        shown = _map(
            ax, _with_obstacles(looks, found.free.reshape(shape)), f"{kind}: {info:.1f} %", cmap=_looks_palette(),
            vmin=-0.5, vmax=MOST + 0.5,
        )  # fmt: skip
        row, col = found.problem.searcher.start
        ax.plot(col, row, "o", ms=4.5, mfc="#d73027", mec="white", mew=0.8)
    bar = figure.colorbar(shown, ax=axes, shrink=0.7, ticks=range(MOST + 1), label="looks")
    bar.ax.set_yticklabels([*map(str, range(MOST)), f"{MOST}+"])
    return figure


def _looks_palette() -> Colormap:
    import matplotlib as mpl
    from matplotlib.colors import ListedColormap

    blues = mpl.colormaps["Blues"]
    colours: list[Any] = ["white", *(blues(0.2 + 0.8 * look / MOST) for look in range(1, MOST + 1))]
    palette = ListedColormap(colours)
    palette.set_bad("black")
    return palette


def _bars(prior: str) -> Callable[[Flown], Figure]:
    return lambda flown: _summary(flown, prior)


def _summary(flown: Flown, prior: str) -> Figure:
    """Information, effort and time of the four planners; the paper's as open diamonds."""
    figure, axes = _panels(1, 3, 2.7, 2.5)
    told = (("info", "information, % of reference"), ("effort", "effort, time constants"), ("timing.cpu_seconds", "s"))
    for ax, (measure, label) in zip(axes, told, strict=True):
        for number, planner in enumerate(PLANNERS):
            found = [flown.measured(f"{kind} {prior}", planner, measure) for kind in KINDS]
            places = np.arange(len(KINDS)) + 0.2 * (number - 1.5)
            means, spread = [float(each.mean()) for each in found], [float(each.std()) for each in found]
            error: Any = spread if measure != "timing.cpu_seconds" else None
            ax.bar(places, means, 0.18, yerr=error, color=COLOURS[planner], error_kw={"lw": 0.7}, label=planner)
            printed = {"info": PRINTED_FINAL, "effort": PRINTED_EFFORT}.get(measure)
            if printed:
                ax.plot(places, printed[prior][planner], "D", ms=3.2, mfc="white", mec="#d73027", mew=0.9, zorder=5)
        ax.set(xticks=range(len(KINDS)), xticklabels=KINDS, ylabel=label)
    axes[0].set_ylim(40, 102)
    axes[1].set_ylim(0.9, None)
    axes[2].set(yscale="log", ylabel="seconds of one core")
    axes[1].plot([], [], "D", ms=3.2, mfc="white", mec="#d73027", mew=0.9, label="published")
    figure.legend(*axes[1].get_legend_handles_labels(), loc="outside upper center", ncols=5, frameon=False)
    return figure


FIGURES: dict[int, Callable[[Flown], Figure]] = {
    4: figure_4,
    5: figure_5,
    6: figure_6,
    7: figure_7,
    8: figure_8,
    9: figure_9,
    10: figure_10,
    **{11 + number: _plans(planner, "uniform") for number, planner in enumerate(PLANNERS)},
    15: figure_15,
    **{16 + number: _plans(planner, "nonuniform") for number, planner in enumerate(PLANNERS)},
    20: _bars("uniform"),
    21: _bars("nonuniform"),
}
