"""Several targets on streets: one track searches, and each target that it finds is followed by a track of its own."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sooner.belief import _tracks_kernels as kernels
from sooner.belief.track_before_detect import Track
from sooner.errors import InvalidProblemError

__all__ = ["Following", "Tracks"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Following:
    """How a target that was found is followed.

    Parameters
    ----------
    lose : float         probability a second that the target is lost, and so explains nothing that is seen later. It
                         is large because of what errors cost: a target that is found twice costs a call, one that is
                         taken for another is not found. What is believed of where it is, if it is not lost, stays
    apart_m : float      what was believed of a target no farther than this from where one is found is believed of it,
                         and what is farther of another; along rows and columns
    drop : float         probability of being lost above which a target is followed no longer

    Raises
    ------
    InvalidProblemError  if a number is out of its range
    """

    lose: float = 0.2
    apart_m: float = 15.0
    drop: float = 1.0 - 1e-6

    def __post_init__(self) -> None:
        if not 0.0 <= self.lose <= 1.0:
            raise InvalidProblemError(f"a probability to lose a target of {self.lose} came; expected one in [0, 1]")
        if not (np.isfinite(self.apart_m) and self.apart_m >= 0.0):
            raise InvalidProblemError(f"targets {self.apart_m} m apart came; expected at least 0")
        if not 0.0 < self.drop <= 1.0:
            raise InvalidProblemError(f"a target that is dropped at {self.drop} came; expected a probability above 0")

    @property
    def vanish(self) -> float:
        """q(phi | s)."""
        return self.lose

    @property
    def appear(self) -> float:
        """The sum over states of q(s | phi): a target that is lost does not come back by itself."""
        return 0.0

    def start_ratio(self, n_cells: int) -> float:
        """A newly explored state begins empty: the target comes there by walking."""
        return 0.0


class Tracks:
    """A track that searches, and those of the targets that it has found.

    A look at cell c has the ratio Z of its likelihoods with a target there and without. Confirmed tracks take in the
    looks first, as if there were no other target. Given what they then hold, the looks z of a second say of another
    target at c, against there being none but those,

    L(z | confirmed, another at c) / L(z | confirmed) = E[1 where one of them is at c, Z_c where none is]
                                                      = e_c + (1 - e_c) Z_c

    with e_c the probability, after the looks, that a confirmed target is at c, and Z_c the product over the looks at
    c. For one look it is Z / (1 - p + p Z), p being the probability before. It is exact where e is, and for one
    confirmed track it is. Of several we take the sum, at most one, and not 1 - prod (1 - e): what they hold after the
    looks excludes one another, as a signal that two of them may have made was made by one. In the same way a later
    confirmed track takes in what the earlier ones leave of the looks, so that two do not gather about one target.
    Approximate is that tracks are kept as if independent from one second to the next, and that a confirmed track does
    not know of those after it.

    Parameters
    ----------
    search : Track
    following : Following

    Attributes
    ----------
    search : Track             of a target not found yet
    confirmed : dict           tracks of the targets that are followed, by number, in the order in which they were found
    places : dict              the node where each of these is likeliest, by number
    found : int                how many were found, those lost again among them
    left : (L,) float          what the newest looks say of another target
    explained : (M,) float     e
    """

    def __init__(self, search: Track, following: Following = Following()) -> None:
        self.search = search
        self.following = following
        self.confirmed: dict[int, Track] = {}
        self.places: dict[int, int] = {}
        self.found = 0
        self.left: Floats = np.empty(0)
        n_cells = search.states.graph.grid.n_cells
        self.explained, self._together = np.zeros(n_cells), np.empty(n_cells)
        self._ratios = np.zeros(search.states.n_nodes)

    def second(
        self, nodes: NDArray[np.int64], cells: NDArray[np.int32], target_ratios: Floats, ratios: Floats
    ) -> tuple[float, int]:
        """One second of all tracks; arguments and answer are those of `Track.second`, about the one that searches."""
        self.left = target_ratios
        self.explained[:] = 0.0
        graph, reverse = self.search.states.graph, self.search.states.reverse
        for number, track in list(self.confirmed.items()):
            _, self.places[number] = track.second(nodes, cells, self.left, self._ratios)
            if track.probability[-1] > self.following.drop:
                del self.confirmed[number], self.places[number]
                continue
            kernels.explain(track.probability, track.found, graph.starts, reverse, graph.cells, self.explained)
            self.left = np.empty(len(cells))
            kernels.unexplained(cells, target_ratios, self.explained, self._together, self.left)
        return self.search.second(nodes, cells, self.left, ratios)

    def confirm(self, node: int) -> int:
        """The target that the search believes near a node is found; the search goes on for another.

        What it believed near goes over into a track of its own, beside the probability that there is none; the search
        keeps what it believed elsewhere, and near it believes what it does where nothing has been seen for long.
        Returns the number of the new track.
        """
        search, near = self.search, self._near(node)
        track = replace(search.copy(), settings=self.following)
        track.hold(np.where(near, track.probability[:-1], 0.0))
        search.hold(np.where(near, np.minimum(search.probability[:-1], search.resting), search.probability[:-1]))
        self.found += 1
        self.confirmed[self.found], self.places[self.found] = track, node
        return self.found

    def copy(self, search: Track) -> Tracks:
        """The same tracks, to go on by themselves, around a copy of the one that searches."""
        other = Tracks(search, self.following)
        other.restore(self)
        return other

    def restore(self, kept: Tracks) -> None:
        """Follow again those that were followed then; the track that searches is not touched."""
        self.confirmed = {number: track.copy() for number, track in kept.confirmed.items()}
        self.places, self.found = dict(kept.places), kept.found
        self.left = kept.left.copy()
        self.explained[:] = kept.explained

    def _near(self, node: int) -> NDArray[np.bool_]:
        """(S,) bool: states at nodes not farther from a node than two targets are apart at least."""
        states, graph = self.search.states, self.search.states.graph
        rows, cols = np.divmod(graph.cells, graph.grid.shape[1])
        apart = np.maximum(np.abs(rows - rows[node]), np.abs(cols - cols[node])) * graph.grid.cell_m
        return np.asarray((apart <= self.following.apart_m)[states.current])
