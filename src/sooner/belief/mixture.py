"""Gaussian mixtures fitted to a surface: where its volume lies, in a few ellipses [Lin2014, section IV-B]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

__all__ = ["Mixture", "fit_mixture"]

CELL_VARIANCE = 1 / 12  # of a point somewhere in a cell; keeps a component on one cell or one row from collapsing


@dataclass(frozen=True, eq=False)
class Mixture:
    """A sum of K scaled bivariate Gaussians, p(x) = sum_k w_k G_k(x)              [Lin2014, eq. (11), (15)].

    Parameters
    ----------
    weights : (K,) float            w, totalling one
    means : (K, 2) float            row and column
    covariances : (K, 2, 2) float
    converged : bool                whether EM converged in the tries it had
    """

    weights: NDArray[np.float64]
    means: NDArray[np.float64]
    covariances: NDArray[np.float64]
    converged: bool = True


def fit_mixture(
    surface: NDArray[np.float64],
    components: int,
    rng: Generator,
    *,
    coarseness: int = 30,
    tolerance: float = 1e-4,
    rounds: int = 500,
    tries: int = 3,
) -> Mixture:
    """Fit `components` Gaussians to a surface: k-means from random points, then expectation maximisation.

    Points approximate the surface: a cell whose height, scaled to 255, rounds to h counts floor(h / 30) times. EM
    ends when the mean log likelihood of a point moves by less than `tolerance`; where it has not after `rounds`, it
    starts again elsewhere, at most `tries` times, and the last fit is kept.

    Parameters
    ----------
    surface : (H, W) float       heights of at least 0
    components : int             reduced to the number of distinct points where there are fewer
    rng : Generator
    coarseness : int             30 in the authors' program

    Notes
    -----
    A compiled fit over counted cells stands here instead of scikit-learn, whose mixture cannot count a point more
    than once: the same optimum (tested against it), without the copies, in 3 to 10 ms rather than 40 to 70, and
    outside the interpreter's lock, so that layers fit in parallel. 1/12, the variance of a point within a cell,
    is added to the variances.

    Examples
    --------
    >>> surface = np.zeros((5, 9))
    >>> surface[2, 1] = surface[2, 7] = 1.0
    >>> mixture = fit_mixture(surface, 2, np.random.default_rng(0))
    >>> sorted(mixture.means[:, 1].round(6).tolist()), mixture.weights.tolist()
    ([1.0, 7.0], [0.5, 0.5])
    """
    from sooner.belief._kernels import fit

    kernel: Any = fit
    points, counts = _points(surface, coarseness)
    middle = points.mean(axis=0)
    components = min(components, len(points))
    for _ in range(max(tries, 1)):
        begin = rng.choice(len(points), components, replace=False, p=counts / counts.sum())
        weights, means, covariances, converged = kernel(
            points - middle, counts, points[begin] - middle, CELL_VARIANCE, tolerance, rounds
        )
        if converged:
            break
    return Mixture(weights, means + middle, covariances, bool(converged))


def _points(surface: NDArray[np.float64], coarseness: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Cells with their counts, (n, 2) and (n,); every cell once where the surface is zero throughout."""
    peak = float(surface.max())
    counts = np.floor(np.rint(surface / peak * 255) / coarseness) if peak > 0 else np.ones(surface.shape)
    rows, cols = np.nonzero(counts)
    return np.column_stack([rows, cols]).astype(np.float64), counts[rows, cols]
