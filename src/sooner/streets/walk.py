"""How a target walks: it rests now and then, and else prefers to go straight on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.streets.target_states import TargetStates

__all__ = ["Bias", "Evasive", "TargetWalk", "turn_weights"]

Bias = Callable[[TargetStates, NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True)
class TargetWalk:
    """A biased random walk over target states, one step a second   [Wolek2020, eq. (1), (2)].

    q(s | s') = p_s                  for s the rest at the node of s'
                (1 - p_s) w(s, s')   for s on from there to a node that touches it

    w falls with the turn from s' to s. From rest it is the same in every direction, and eq. (1) does not hold: a target
    at rest goes on in the next step. Where no node touches, it stays. A walk alone goes straight on twice as often as
    straight back.

    Parameters
    ----------
    rest : float             p_s, probability to rest in a step, in [0, 1)
    turn_scale : float       c_m >= 0: 0 for no bias
    turn_shape : float       c_d > 0
    bias : callable or None  (states, weights) -> weights: what w is multiplied by before it is made to total one, for
                             each transition; its entries at rest are left alone. `Evasive` is one
    rest_again : float or None    probability, in [0, 1], that a target at rest stays so for another step; None: as
                             great as that of going to any one neighbour

    Raises
    ------
    InvalidProblemError      if a parameter is out of its range, or the bias gives no numbers, or negative ones

    Notes
    -----
    The paper gives eq. (1) for states that are not rest, and "a uniform probability ... to all neighboring states" for
    those that are. Whether a rest state is its own neighbour it does not say; its figures are nearest if it is none.

    Examples
    --------
    >>> from sooner.grid import Grid
    >>> from sooner.streets.occupancy import OccupancyGraph
    >>> states = TargetStates(OccupancyGraph.of(Grid((1, 3)), cells=[0, 1, 2], edges=[(0, 1), (1, 2)]))
    >>> q = TargetWalk().weights(states)
    >>> q[states.outgoing_starts[3] : states.outgoing_starts[4]].round(4)    # (0, 1): rests, back, on
    array([0.5   , 0.1667, 0.3333])
    """

    rest: float = 0.5
    turn_scale: float = 1.0
    turn_shape: float = 0.1
    bias: Bias | None = None
    rest_again: float | None = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.rest < 1.0:
            raise InvalidProblemError(f"a probability to rest of {self.rest} came; expected a number in [0, 1)")
        if self.rest_again is not None and not 0.0 <= self.rest_again <= 1.0:
            raise InvalidProblemError(f"a probability to rest again of {self.rest_again} came; expected one in [0, 1]")
        if not (np.isfinite(self.turn_scale) and self.turn_scale >= 0.0):
            raise InvalidProblemError(f"a scale of turns of {self.turn_scale} came; expected a number of at least 0")
        if not (np.isfinite(self.turn_shape) and self.turn_shape > 0.0):
            raise InvalidProblemError(f"a shape of turns of {self.turn_shape} came; expected a positive number")

    def weights(self, states: TargetStates) -> NDArray[np.float64]:
        """(transitions,) float: q(s | s') in the order of `states.outgoing_states`; each state's row totals one."""
        rows = np.repeat(np.arange(states.n_states), np.diff(states.outgoing_starts))
        to_rest = states.is_rest[states.outgoing_states]
        turns = turn_weights(_turned(states.heading[rows], states.heading[states.outgoing_states]), self)
        w = np.where(states.is_rest[rows], 1.0, turns)
        if self.bias is not None:
            w = w * _biased(self.bias, states, w)
        w = np.where(to_rest, 0.0, w)
        totals = np.bincount(rows, w, states.n_states)
        moves = np.where(totals > 0.0, np.where(states.is_rest, self._leaves(states), 1.0 - self.rest), 0.0)
        on = w * (moves / np.where(totals > 0.0, totals, 1.0))[rows]
        return np.where(to_rest, (1.0 - moves)[rows], on)

    def _leaves(self, states: TargetStates) -> NDArray[np.float64]:
        """(S,) float: probability to leave rest, at the node of each state."""
        if self.rest_again is None:
            degrees = states.graph.degrees[states.current]
            return np.asarray(degrees / (degrees + 1.0))
        return np.full(states.n_states, 1.0 - self.rest_again)

    def started(self, states: TargetStates, rng: Generator, n_targets: int = 1) -> NDArray[np.int64]:
        """(targets,) int64: states at rest, at nodes drawn uniformly."""
        return rng.integers(states.n_nodes, size=n_targets)

    def walked(self, states: TargetStates, start: ArrayLike, seconds: int, rng: Generator) -> NDArray[np.int64]:
        """(seconds + 1, targets) int64: the state of each target at each second, from where each starts."""
        from sooner.streets._walk_kernels import walk

        now = np.array(start, np.int64, ndmin=1)
        path = np.empty((seconds + 1, len(now)), np.int64)
        path[0] = now
        graph, draws = states.graph, rng.random((seconds, len(now)))
        walk(now, draws, states.current, graph.starts, states.outgoing_starts, self.weights(states), path[1:])
        return path


def turn_weights(turned: ArrayLike, walk: TargetWalk) -> NDArray[np.float64]:
    """Weight of a turn in [0, pi], before it is made to total one   [Wolek2020, eq. (2)].

    ((c_d - c_m / pi) turn + 1 + c_m) / (1 + c_d turn): 1 + c_m straight on, 1 straight back

    >>> turn_weights([0.0, pi], TargetWalk()).round(6)
    array([2., 1.])
    """
    turn, scale, shape = np.asarray(turned, np.float64), walk.turn_scale, walk.turn_shape
    return ((shape - scale / pi) * turn + 1.0 + scale) / (1.0 + shape * turn)


@dataclass(frozen=True, eq=False)
class Evasive:
    """A bias of a target that goes where no searcher is near   [suggested in Wolek2020, sec. II.B].

    factor = b + (1 - b) (1 - exp(-d^2 / 2 reach^2)),   d from the node it would go to, to the nearest searcher

    Parameters
    ----------
    places_m : (A, 2) float     searchers, metres east and north; where there are none, nothing changes
    reach_m : float             how far a searcher is felt, 0.001 to 1e6
    boldness : float            b, the factor beneath a searcher, in (0, 1]: 1 for no fear

    Raises
    ------
    InvalidProblemError         if places are no finite numbers, reach is out of [0.001, 1e6], or boldness out of (0, 1]
    """

    places_m: NDArray[np.float64]
    reach_m: float = 12.5
    boldness: float = 0.05

    def __post_init__(self) -> None:
        places = np.array(self.places_m, np.float64).reshape(-1, 2)
        if not np.isfinite(places).all():
            raise InvalidProblemError("places of searchers that are no numbers came; expected metres")
        if not 0.001 <= self.reach_m <= 1e6:  # its square stays a number
            raise InvalidProblemError(f"a reach of {self.reach_m} m came; expected 0.001 to 1e6 m")
        if not 0.0 < self.boldness <= 1.0:
            raise InvalidProblemError(f"a boldness of {self.boldness} came; expected a number in (0, 1]")
        object.__setattr__(self, "places_m", places)

    def __call__(self, states: TargetStates, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """(transitions,) float: the factor of each transition, by the node that it leads to."""
        return self.factors(states.graph.positions_m)[states.current[states.outgoing_states]]

    def factors(self, positions_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N,) float: the factor of going to each node; `_walk_kernels.step_biased` takes these."""
        if len(self.places_m) == 0:
            return np.ones(len(positions_m))
        apart = positions_m[:, None, :] - self.places_m[None, :, :]
        nearest = (apart**2).sum(axis=2).min(axis=1)
        return self.boldness - (1.0 - self.boldness) * np.asarray(np.expm1(-nearest / (2.0 * self.reach_m**2)))


def _turned(before: NDArray[np.float64], after: NDArray[np.float64]) -> NDArray[np.float64]:
    """The smallest angle between two headings, in [0, pi]; 0 where one of them is at rest."""
    apart = np.abs(after - before)
    return np.nan_to_num(np.minimum(apart, 2.0 * pi - apart))


def _biased(bias: Bias, states: TargetStates, weights: NDArray[np.float64]) -> NDArray[np.float64]:
    factors = np.asarray(bias(states, weights), np.float64)
    if factors.shape != weights.shape or not np.isfinite(factors).all() or (factors < 0.0).any():
        raise InvalidProblemError(
            f"a bias that gives an array of shape {factors.shape}, or no finite numbers of at least 0, came; "
            f"expected one factor for each of {len(weights)} transitions"
        )
    return factors
