"""Shapes that scenarios are made of: hills, and smooth noise."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

__all__ = ["hill", "smooth_noise"]


def hill(
    shape: tuple[int, int], centre: tuple[float, float], spread: tuple[float, float], turn: float = 0.0
) -> NDArray[np.float64]:
    """(H, W): a Gaussian hill of height 1 at (row, col) `centre`, stretched by `spread`, turned by `turn` radians."""
    rows, cols = np.mgrid[0 : shape[0], 0 : shape[1]].astype(np.float64)
    down, right = rows - centre[0], cols - centre[1]
    along = np.cos(turn) * right - np.sin(turn) * down
    across = np.sin(turn) * right + np.cos(turn) * down
    height: NDArray[np.float64] = np.exp(-0.5 * ((along / spread[1]) ** 2 + (across / spread[0]) ** 2))
    return height


def smooth_noise(shape: tuple[int, int], rng: Generator, widths: tuple[float, ...]) -> NDArray[np.float64]:
    """(H, W): noise smoothed at several widths, each half as strong as the one before; mean 0, deviation 1."""
    from scipy.ndimage import gaussian_filter

    total = np.zeros(shape)
    for number, width in enumerate(widths):
        layer = gaussian_filter(rng.standard_normal(shape), width, mode="reflect")
        total += layer / layer.std() * 0.5**number
    noise: NDArray[np.float64] = (total - total.mean()) / total.std()
    return noise
