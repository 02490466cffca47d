"""Layers: numbers per cell with the colours that say what they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.plotting.style import FLIGHT, GLIMPSE, LOOKS, NOWHERE, POC, ROCK

__all__ = [
    "Layer",
    "flight_colours",
    "glimpse_layer",
    "looks_layer",
    "painted",
    "poc_layer",
    "there_layer",
    "time_layer",
]


@dataclass(frozen=True, eq=False)
class Layer:
    """What is drawn over cells.

    Parameters
    ----------
    values : (N,) float          NaN: nothing to say
    colours, norm                of matplotlib
    ends : (str, str)            what the palest and the darkest colour mean
    """

    values: NDArray[np.float64]
    colours: Any
    norm: Any
    ends: tuple[str, str]


def poc_layer(poc: NDArray[np.float64], peak: float) -> Layer:
    """POC; square root, so that faint places show, and never quite black, so that a flight does."""
    from matplotlib.colors import PowerNorm

    return Layer(poc, _part_of(POC, 0.0, 0.8), PowerNorm(0.5, 0.0, max(peak, 1e-300)), ("unlikely", "likely"))


def there_layer(values: NDArray[np.float64], peak: float) -> Layer:
    """What there is to collect in cells that hold much alike; pale, so that a flight over all of them shows."""
    from matplotlib.colors import Normalize

    return Layer(values, _part_of(POC, 0.0, 0.5), Normalize(0.0, max(peak, 1e-300)), ("0", f"{peak:.3g}"))


def time_layer(times: NDArray[np.float64]) -> Layer:
    """When, in the colours of the flight."""
    from matplotlib.colors import Normalize

    last = float(np.nanmax(times, initial=0.0))
    return Layer(times, flight_colours(), Normalize(0.0, max(last, 1e-9)), ("0", f"{last:.0f}"))


def looks_layer(looks: NDArray[np.int64]) -> Layer:
    """How often a cell was looked at."""
    from matplotlib.colors import Normalize

    most = max(int(looks.max()), 1)
    values = np.where(looks > 0, looks, np.nan).astype(np.float64)
    return Layer(values, _part_of(LOOKS, 0.25, 1.0), Normalize(min(1, most - 1), most), ("1", str(most)))


def effort_layer(effort: NDArray[np.float64]) -> Layer:
    """POD of so much effort on each cell, percent; nothing where there was none."""
    from matplotlib.colors import Normalize

    values = np.where(effort > 0, -100.0 * np.expm1(-effort), np.nan)
    return Layer(values, _part_of(LOOKS, 0.25, 1.0), Normalize(0, 100), ("0", "100"))


def glimpse_layer(glimpse: NDArray[np.float64]) -> Layer:
    """How well one look detects."""
    from matplotlib.colors import Normalize

    low, high = float(glimpse.min()), float(glimpse.max())
    return Layer(glimpse, _part_of(GLIMPSE, 0.15, 0.9), Normalize(low, high), (f"{100 * low:.0f}", f"{100 * high:.0f}"))


def flight_colours() -> Any:
    """By time, from dark to bright, but not as pale as the paper."""
    return _part_of(FLIGHT, 0.0, 0.9)


def _part_of(name: str, low: float, high: float) -> Any:
    import matplotlib as mpl
    from matplotlib.colors import LinearSegmentedColormap

    part = LinearSegmentedColormap.from_list(name, mpl.colormaps[name](np.linspace(low, high, 256)))
    return part.with_extremes(bad=NOWHERE)


def painted(layer: Layer, obstacles: NDArray[np.bool_] | None) -> NDArray[np.float64]:
    """(N, 4) float: red, green, blue and opacity of every cell, obstacles in their own colour."""
    from matplotlib.colors import to_rgba

    shown: NDArray[np.float64] = layer.colours(layer.norm(np.ma.masked_invalid(layer.values)))
    if obstacles is not None:
        shown[obstacles.ravel()] = to_rgba(ROCK)
    return shown
