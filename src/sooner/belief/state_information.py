"""Information about cell states: how many bits one look at a void, unoccupied or occupied cell is expected to teach."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError

__all__ = ["InformationTable", "state_entropy", "state_information"]

Floats = NDArray[np.float64]

NODE_SPAN = (-7.5, 11.0)  # log-odds of a node; below, less than a hundredth of a bit is unknown; above, one is certain
TARGET_SPAN = (-11.0, 11.0)  # log-odds of a target where there is a node
SHAPE = (241, 321)
COARSE = (81, 65)  # every third and fifth entry is computed; between them splines
CHUNK = 2_048  # cells at a time


def state_entropy(void: ArrayLike, unoccupied: ArrayLike, occupied: ArrayLike) -> Floats:
    """Bits that are not known of each cell's state.

    H(C) = -v log2 v - u log2 u - o log2 o                                    [Wolek2020, eq. (16)]

    Examples
    --------
    >>> state_entropy([1.0, 0.5, 0.25], [0.0, 0.25, 0.75], [0.0, 0.25, 0.0]).round(3)
    array([0.   , 1.5  , 0.811])
    """
    return np.asarray(0.0 - sum(_x_log_x(np.asarray(p, np.float64)) for p in (void, unoccupied, occupied)))


def state_information(
    void: ArrayLike, unoccupied: ArrayLike, occupied: ArrayLike, p_map: ArrayLike, p_target: ArrayLike
) -> Floats:
    """Bits that one look with both sensors is expected to teach, by the joint table of state and levels.

    I(C; G, Z) = H(C) - H(C | G, Z),  H(C | G, Z) = -sum_{f, l, c} k_c log2(k_c / p(g_l, z_f))
    k_V = v g(l|V) z(f|V,U),  k_U = u g(l|U,O) z(f|V,U),  k_O = o g(l|U,O) z(f|O)      [Wolek2020, eq. (16) to (18)]

    Parameters
    ----------
    void, unoccupied, occupied : (M,) float    they total one
    p_map : (2, n_g) float                     P(level | void) and P(level | node)
    p_target : (2, n_z) float                  P(level | no target) and P(level | target)

    Returns
    -------
    (M,) float                                 between 0 and the entropy

    Raises
    ------
    InvalidProblemError                        if probabilities of levels do not total one

    Examples
    --------
    >>> perfect = np.eye(2)
    >>> state_information([0.5], [0.25], [0.25], perfect, perfect)
    array([1.5])
    """
    v, u, o = (np.ravel(np.asarray(p, np.float64)) for p in (void, unoccupied, occupied))
    g, z = _levels(p_map), _levels(p_target)
    chunks = range(0, max(v.size, 1), CHUNK)
    parts = (slice(start, start + CHUNK) for start in chunks)
    return np.concatenate([_of_chunk(v[part], u[part], o[part], g, z) for part in parts])


@dataclass(frozen=True, eq=False)
class InformationTable:
    """`state_information` of one pair of sensors, ready to be looked up for many cells.

    Bilinear in the log-odds of a node and of a target on it, in which information has no steep ends: with 241 x 321
    entries it differs from the sum by less than 0.0004 bits, wherever at least 0.01 bits are unknown.

    Parameters
    ----------
    p_map : (2, n_g) float       P(level | void) and P(level | node)
    p_target : (2, n_z) float    P(level | no target) and P(level | target)
    least : float                a cell of which fewer bits are unknown counts as known: its information is 0

    Notes
    -----
    The paper computes the sum each time and does not say what it does where little is unknown.

    Examples
    --------
    >>> noise, signal = np.array([0.9, 0.1]), np.array([0.2, 0.8])
    >>> table = InformationTable(np.stack([noise, signal]), np.stack([noise, signal]))
    >>> void, unoccupied, occupied = np.array([[0.9, 0.0, 0.9999], [0.09, 0.5, 0.0001], [0.01, 0.5, 0.0]])
    >>> table.information(void, unoccupied, occupied).round(3)
    array([0.182, 0.397, 0.   ])
    """

    p_map: Floats
    p_target: Floats
    least: float = 0.01

    def __post_init__(self) -> None:
        object.__setattr__(self, "p_map", _levels(self.p_map))
        object.__setattr__(self, "p_target", _levels(self.p_target))
        if not 0.0 <= self.least <= 1.0:
            raise InvalidProblemError(f"a least entropy of {self.least} bits came; expected one in [0, 1]")

    @cached_property
    def table(self) -> Floats:
        """(241, 321) float: bits by log-odds of a node, and of a target on it.

        The sum is computed at every 15th entry, and is so smooth that cubic splines give the others to 2e-5.
        """
        from scipy.interpolate import RectBivariateSpline

        a, b = (np.linspace(*span, n) for span, n in zip((NODE_SPAN, TARGET_SPAN), COARSE, strict=True))
        node, target = np.meshgrid(1.0 / (1.0 + np.exp(-a)), 1.0 / (1.0 + np.exp(-b)), indexing="ij")
        three = 1.0 - node, node * (1.0 - target), node * target
        exact = state_information(*three, self.p_map, self.p_target).reshape(COARSE)
        fine = (np.linspace(*span, n) for span, n in zip((NODE_SPAN, TARGET_SPAN), SHAPE, strict=True))
        return np.asarray(np.maximum(RectBivariateSpline(a, b, exact)(*fine), 0.0), order="C")

    def information(self, void: Floats, unoccupied: Floats, occupied: Floats, out: Floats | None = None) -> Floats:
        """(M,) bits that one look at each cell is expected to teach; written to `out` where it is given."""
        from sooner.belief._state_information_kernels import look_up

        bits = np.empty_like(void) if out is None else out
        look_up(void, unoccupied, occupied, np.array(NODE_SPAN), np.array(TARGET_SPAN), self.table, self.least, bits)
        return bits


def _levels(probabilities: ArrayLike) -> Floats:
    p = np.asarray(probabilities, np.float64)
    if p.ndim != 2 or p.shape[0] != 2 or not (p >= 0).all() or not np.allclose(p.sum(axis=1), 1.0):
        raise InvalidProblemError(
            f"probabilities of levels of shape {p.shape} came; expected (2, n) that total one, of noise and of signal"
        )
    return p


def _of_chunk(v: Floats, u: Floats, o: Floats, g: Floats, z: Floats) -> Floats:
    """`state_information` by H(G, Z) - H(G, Z | C), which is the same: the second is known beforehand."""
    empty, free, full = (np.multiply.outer(g[i], z[j]).ravel() for i, j in ((0, 0), (1, 0), (1, 1)))
    levels = np.outer(v, empty) + np.outer(u, free) + np.outer(o, full)
    certain = sum(p * _x_log_x(joint).sum() for p, joint in ((v, empty), (u, free), (o, full)))
    return np.asarray(np.clip(certain - _x_log_x(levels).sum(axis=1), 0.0, state_entropy(v, u, o)))


def _x_log_x(p: Floats) -> Floats:
    """X log2 x, 0 for x = 0."""
    return np.asarray(p * np.log2(np.where(p > 0, p, 1.0)))
