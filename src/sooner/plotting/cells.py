"""Layers over cells: squares as an image, hexagons as hexagons, north up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.plotting.style import GLIMPSE, INK, LOOKS, POC

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["CellMap"]

ROCK = "#8c6d46"
MOST_HEXAGONS = 60_000  # beyond this nobody sees their corners


@dataclass(frozen=True)
class CellMap:
    """Draws numbers per cell where the cells lie, in metres."""

    grid: Grid

    def draw_layer(
        self, axes: Axes, values: NDArray[np.float64], kind: str, peak: float, numbered: bool = False
    ) -> None:
        """Draw (N,) values; `kind` is "poc", "looks" or "glimpse"; `peak` the POC drawn darkest."""
        colours, norm = _colours(kind, peak, values)
        obstacles = self.grid.obstacles
        drawn: Any = np.ma.masked_array(values, False if obstacles is None else obstacles.ravel())
        if self.grid.connectivity == "hex" and self.grid.n_cells <= MOST_HEXAGONS:
            self._hexagons(axes, drawn, colours, norm)
        else:
            self._squares(axes, drawn, colours, norm)
        self._frame(axes, numbered)

    def _squares(self, axes: Axes, values: Any, colours: Any, norm: Any) -> None:
        axes.imshow(
            values.reshape(self.grid.shape),
            cmap=colours,
            norm=norm,
            extent=self._extent(),
            interpolation="nearest",
            zorder=1,
        )

    def _hexagons(self, axes: Axes, values: Any, colours: Any, norm: Any) -> None:
        from matplotlib.collections import PolyCollection

        angles = np.pi / 6 + np.arange(6) * np.pi / 3
        corners = self.grid.cell_m / np.sqrt(3) * np.column_stack([np.cos(angles), np.sin(angles)])
        shapes = self.grid.centres_m[:, None, :] + corners
        layer = PolyCollection(
            list(shapes), array=values, cmap=colours, norm=norm, edgecolors="face", linewidths=0.3, zorder=1
        )
        axes.add_collection(layer)
        axes.set_aspect("equal")

    def _extent(self) -> tuple[float, float, float, float]:
        """West, east, south, north edges, in metres."""
        half = self.grid.cell_m / 2
        low, high = self.grid.centres_m.min(axis=0) - half, self.grid.centres_m.max(axis=0) + half
        return float(low[0]), float(high[0]), float(low[1]), float(high[1])

    def _frame(self, axes: Axes, numbered: bool) -> None:
        west, east, south, north = self._extent()
        axes.set_xlim(west, east)
        axes.set_ylim(south, north)
        axes.set_facecolor(ROCK if self.grid.obstacles is not None else "white")
        if not numbered:
            axes.set_xticks([])
            axes.set_yticks([])
            return
        height, width = self.grid.shape
        rows, cols = _round_ticks(height), _round_ticks(width)
        axes.set_xticks([col * self.grid.cell_m for col in cols], [str(col) for col in cols])
        y = self.grid.centres_m[::width, 1]
        axes.set_yticks([float(y[row]) for row in rows], [str(row) for row in rows])
        axes.tick_params(labelsize=7.5, length=0, pad=3)
        axes.set_xlabel("column", fontsize=8, color=INK, labelpad=1)
        axes.set_ylabel("row", fontsize=8, color=INK, labelpad=1)


def _round_ticks(count: int) -> list[int]:
    """About five round numbers below `count`, from 0.

    >>> _round_ticks(100)
    [0, 20, 40, 60, 80]
    """
    step = next(
        s for base in (1, 10, 100, 1000, 10000, 10**5, 10**6) for s in (base, 2 * base, 5 * base) if count / s <= 6
    )
    return list(range(0, count, step))


def _colours(kind: str, peak: float, values: NDArray[np.float64]) -> tuple[Any, Any]:
    import matplotlib as mpl
    from matplotlib.colors import LinearSegmentedColormap, Normalize, PowerNorm

    if kind == "poc":  # square root, so that faint places show; not to full black, so that the flight does
        colours = LinearSegmentedColormap.from_list("poc", mpl.colormaps[POC](np.linspace(0.0, 0.8, 256)))
        return colours.with_extremes(bad=ROCK), PowerNorm(0.5, 0.0, max(peak, 1e-300))
    if kind == "looks":
        return mpl.colormaps[LOOKS].with_extremes(bad=ROCK), Normalize(0.0, max(float(values.max()), 1.0))
    return mpl.colormaps[GLIMPSE].with_extremes(bad=ROCK), Normalize(0.0, 1.0)
