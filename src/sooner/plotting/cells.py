"""Layers over cells: squares as an image, hexagons as hexagons, north up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.plotting.layers import Layer, painted
from sooner.plotting.style import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["CellMap"]

MOST_HEXAGONS = 60_000  # beyond this nobody sees their corners


@dataclass(frozen=True)
class CellMap:
    """Draws numbers per cell where the cells lie, in metres."""

    grid: Grid

    def draw_layer(self, axes: Axes, layer: Layer, numbered: bool = False) -> None:
        """Draw a layer; `numbered` shows rows and columns as plan files count them."""
        shown = painted(layer, self.grid.obstacles)
        if self.grid.connectivity == "hex" and self.grid.n_cells <= MOST_HEXAGONS:
            self._hexagons(axes, shown)
        else:
            axes.imshow(shown.reshape(*self.grid.shape, 4), extent=self.extent, interpolation="nearest", zorder=1)
        self._frame(axes, numbered)

    def _hexagons(self, axes: Axes, shown: NDArray[np.float64]) -> None:
        from matplotlib.collections import PolyCollection

        angles = np.pi / 6 + np.arange(6) * np.pi / 3
        corners = self.grid.cell_m / np.sqrt(3) * np.column_stack([np.cos(angles), np.sin(angles)])
        shapes = self.grid.centres_m[:, None, :] + corners
        axes.add_collection(PolyCollection(list(shapes), facecolors=shown, edgecolors="face", linewidths=0.3, zorder=1))
        axes.set_aspect("equal")

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """West, east, south, north edges, in metres."""
        half = self.grid.cell_m / 2
        low, high = self.grid.centres_m.min(axis=0) - half, self.grid.centres_m.max(axis=0) + half
        return float(low[0]), float(high[0]), float(low[1]), float(high[1])

    @property
    def tall(self) -> float:
        """Height over width."""
        west, east, south, north = self.extent
        return (north - south) / (east - west)

    def _frame(self, axes: Axes, numbered: bool) -> None:
        west, east, south, north = self.extent
        axes.set_xlim(west, east)
        axes.set_ylim(south, north)
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
