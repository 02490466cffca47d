"""Mode Goodness Ratio: which hills of the surface are worth a flight, and in what order.

L. Lin, M. A. Goodrich, "Hierarchical heuristic search using a Gaussian mixture model for UAV coverage planning",
IEEE Transactions on Cybernetics 44 (2014), 2532-2544, section IV-B, eq. (11) to (20).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.belief.mixture import Mixture, fit_mixture
from sooner.decomposition import modes
from sooner.planners.hill_climb import Field

__all__ = ["ModeGoodness", "match_modes", "mode_goodness"]

VOLUME_3_SIGMA = 0.9946  # "roughly 99.46 %" of a bivariate Gaussian's volume; it cancels in every ratio


@dataclass(frozen=True)
class ModeGoodness:
    """Fit Gaussians to G', give each the mode nearest to its mean, rank these by Mode Goodness.

    Parameters
    ----------
    exponent : float      of the distance ratio against peakedness: MG = D^exponent V / A. The paper weighs them
                          alike (1) and leaves the trade open (section VI)
    coarseness : int      of the points that stand for the surface (`belief.fit_mixture`)
    """

    exponent: float = 1.0
    coarseness: int = 30

    def ranked(self, field: Field, k: int, rng: Generator) -> NDArray[np.int64]:
        """(K,) int: cells of the k best modes, best first; fewer where there are fewer."""
        peaks = modes(field.grid, field.surface.ravel())
        peaks = peaks[field.within[peaks]]
        if len(peaks) == 0:
            return peaks
        mixture = fit_mixture(field.surface, min(k, len(peaks)), rng, coarseness=self.coarseness)
        cells = match_modes(field, mixture, peaks)
        alpha = field.steps_from_start[cells] + field.steps_to_end[cells]  # eq. (13)
        goodness = mode_goodness(mixture, alpha, field.budget, self.exponent)
        return cells[np.argsort(-goodness, kind="stable")]


def match_modes(field: Field, mixture: Mixture, peaks: NDArray[np.int64]) -> NDArray[np.int64]:
    """(K,) int: for each Gaussian in turn, the unused mode nearest to its mean."""
    at = np.column_stack(np.divmod(peaks, field.grid.shape[1])).astype(np.float64)
    apart = ((at[None, :, :] - mixture.means[:, None, :]) ** 2).sum(axis=2)  # (K, M)
    matched = np.zeros(len(mixture.means), np.int64)
    for k in range(len(matched)):
        nearest = int(np.argmin(apart[k]))
        matched[k] = peaks[nearest]
        apart[:, nearest] = np.inf
    return matched


def mode_goodness(
    mixture: Mixture, alpha: NDArray[np.integer], steps: int, exponent: float = 1.0
) -> NDArray[np.float64]:
    """Mode Goodness of every Gaussian, eq. (12) to (17); divide by the first for the ratios of eq. (18) to (20).

    D = log10 floor(T / (alpha + 1)),  V = 0.9946 w,  A = 9 sigma_x' sigma_y',  MG = D^exponent V / A

    sigma_x' sigma_y' is the square root of the covariance's determinant. The logarithm is decimal and the quotient
    rounded down, which the paper does not say, but which the author's stored Gaussians need for his ratios.

    Parameters
    ----------
    alpha : (K,) int           steps from the start to each mode, and from there to the end where there is one
    steps : int                T

    Returns
    -------
    (K,) float                 -inf where the mode cannot be reached in T steps
    """
    quotient = steps // (np.asarray(alpha, np.int64) + 1)
    D = np.where(quotient > 0, np.log10(np.maximum(quotient, 1)), -np.inf)
    V = VOLUME_3_SIGMA * mixture.weights
    A = 9.0 * np.sqrt(np.linalg.det(mixture.covariances))
    return np.where(quotient > 0, np.maximum(D, 0.0) ** exponent * V / A, -np.inf)
