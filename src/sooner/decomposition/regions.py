"""Ground cut into regions, and which of them meet [Kuhlman2017, sec. 5.3 and 6.2]."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid

__all__ = ["Pieces", "Regions"]


@dataclass(frozen=True, eq=False)
class Regions:
    """Connected pieces of ground, numbered 0 to R - 1, and the pairs between which a searcher may move.

    Parameters
    ----------
    labels : (H, W) int32      region of each cell; -1 on obstacles, and on free cells that belong to none
    adjacency : (E, 2) int64   pairs of regions, the lower number first, each pair once, in order

    Raises
    ------
    InvalidProblemError        if there is no region, a number is left out, a region falls apart, or a pair makes no
                               sense

    Examples
    --------
    >>> labels = np.array([[0, 0, 1, 1, -1], [0, -1, -1, 1, 2]], np.int32)
    >>> regions = Regions.from_labels(Grid((2, 5), obstacles=labels < 0), labels)
    >>> regions.n_regions, regions.adjacency.tolist(), regions.sizes.tolist()
    (3, [[0, 1], [1, 2]], [3, 3, 1])
    >>> regions.cells(1).tolist(), regions.centres.tolist()
    ([2, 3, 8], [0, 3, 9])
    """

    labels: NDArray[np.int32]
    adjacency: NDArray[np.int64]

    def __post_init__(self) -> None:
        if self.labels.ndim != 2 or not np.issubdtype(self.labels.dtype, np.integer):
            raise InvalidProblemError(
                f"labels of shape {self.labels.shape} and type {self.labels.dtype} came; expected (H, W) whole numbers"
            )
        object.__setattr__(self, "labels", np.ascontiguousarray(self.labels, np.int32))
        pairs = np.asarray(self.adjacency, np.int64).reshape(-1, 2)
        object.__setattr__(self, "adjacency", pairs)
        self._check_labels()
        in_order = np.array_equal(np.unique(pairs, axis=0), pairs)
        if not in_order or (pairs < 0).any() or (pairs >= self.n_regions).any() or (pairs[:, 0] >= pairs[:, 1]).any():
            raise InvalidProblemError(
                f"adjacency {pairs.tolist()[:8]} came; expected pairs of numbers below {self.n_regions}, "
                "the lower first, each once, in order"
            )

    @classmethod
    def from_labels(cls, grid: Grid, labels: NDArray[np.int32]) -> Regions:
        """Regions of the given labels; adjacent if they share a side of a cell, or free ground in none lies between.

        Free cells of label -1 that hang together (by sides) join all the regions around them in pairs: so the graph of
        regions is as connected as the free ground is [Kuhlman2017, sec. 6.2, "repair region connections"].
        """
        if labels.shape != grid.shape:
            raise InvalidProblemError(f"labels of shape {labels.shape} came; the grid has {grid.shape}")
        if grid.connectivity == "hex":
            raise InvalidProblemError("hexagonal cells came; expected square ones")
        passable = grid.passable.reshape(grid.shape)
        if (labels[~passable] >= 0).any():
            row, col = np.argwhere(~passable & (labels >= 0))[0]
            raise InvalidProblemError(f"the obstacle [{row}, {col}] has label {labels[row, col]}; expected -1")
        return cls(labels, _adjacency(passable, labels))

    @property
    def n_regions(self) -> int:
        """Number of regions R."""
        return len(self.sizes)

    @cached_property
    def sizes(self) -> NDArray[np.int64]:
        """(R,) int: cells of each region."""
        return np.bincount(self._pieces.label, self._pieces.stop - self._pieces.start).astype(np.int64)

    @cached_property
    def centres(self) -> NDArray[np.int64]:
        """(R,) int: the region's cell nearest its centroid, the first of them if several are [Kuhlman2017, fig. 2]."""
        found = np.empty(self.n_regions, np.int64)
        for region in range(self.n_regions):
            cells = self.cells(region)
            rows, cols = np.divmod(cells, self.labels.shape[1])
            apart = (rows - rows.mean()) ** 2 + (cols - cols.mean()) ** 2
            found[region] = cells[np.argmin(np.round(apart, 9))]  # rounded, so that ties are ties
        return found

    def cells(self, region: int) -> NDArray[np.int64]:
        """Numbers of a region's cells, row by row."""
        box = self.box(region)
        rows, cols = np.nonzero(self.labels[box] == region)
        numbers: NDArray[np.int64] = (rows + box[0].start) * self.labels.shape[1] + cols + box[1].start
        return numbers

    def box(self, region: int) -> tuple[slice, slice]:
        """Rows and columns of the smallest rectangle that holds a region."""
        if not 0 <= region < self.n_regions:
            raise InvalidProblemError(f"region {region} came; there are {self.n_regions}, counted from 0")
        return self._boxes[region]

    @cached_property
    def _pieces(self) -> Pieces:
        return Pieces.of(self.labels)

    @cached_property
    def _boxes(self) -> list[tuple[slice, slice]]:
        from scipy.ndimage import find_objects

        boxes: list[tuple[slice, slice]] = find_objects(self.labels + 1)
        return boxes

    def _check_labels(self) -> None:
        if self.labels.size == 0 or self.labels.min() < -1 or self.labels.max() < 0:
            raise InvalidProblemError(
                "labels came without any region, or below -1; expected numbers from 0, and -1 where there is none"
            )
        if not self.sizes.all():
            raise InvalidProblemError(
                f"no cell has label {np.argmin(self.sizes)}; expected all numbers up to {self.n_regions - 1} to be used"
            )
        parts, part = self._pieces.parts()
        region = np.zeros(parts, np.int64)
        region[part] = self._pieces.label
        in_parts = np.bincount(region)
        if (in_parts > 1).any():
            worst = int(np.argmax(in_parts))
            raise InvalidProblemError(f"region {worst} came in {in_parts[worst]} parts; expected it to hang together")


class Pieces(NamedTuple):
    """Columns of the map cut where the label changes: a slice's pieces [Kuhlman2017, sec. 6.2].

    A place counts down the first column, passes one that is no cell, and goes on down the second.
    """

    shape: tuple[int, int]
    start: NDArray[np.int64]  # (M,) place of the northmost cell of each piece, in order
    stop: NDArray[np.int64]  # (M,) place past the southmost
    label: NDArray[np.int32]  # (M,) not negative: ground of label -1 is in no piece

    @classmethod
    def of(cls, labels: NDArray[np.int32]) -> Pieces:
        """Cut a map of labels (H, W).

        >>> Pieces.of(np.array([[0, 0], [0, 1], [-1, 1]], np.int32)).label.tolist()
        [0, 0, 1]
        """
        height, width = labels.shape
        padded = np.full((width, height + 1), -1, np.int32)
        padded[:, :height] = labels.T
        line = padded.ravel()
        start = np.concatenate([[0], np.flatnonzero(line[1:] != line[:-1]) + 1])
        stop = np.append(start[1:], line.size)
        ground = line[start] >= 0
        return cls((height, width), start[ground], stop[ground], line[start[ground]])

    @property
    def column(self) -> NDArray[np.int64]:
        """(M,) int: where each piece lies."""
        column: NDArray[np.int64] = self.start // (self.shape[0] + 1)
        return column

    def beside(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Pairs of pieces in neighbouring columns that share sides of cells: west, east, and how many."""
        period = self.shape[0] + 1
        first = np.searchsorted(self.stop, self.start + period, "right")
        count = np.maximum(np.searchsorted(self.start, self.stop + period, "left") - first, 0)
        west = np.repeat(np.arange(len(self.start)), count)
        east = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count - first, count)
        shared = np.minimum(self.stop[west] + period, self.stop[east])
        shared -= np.maximum(self.start[west] + period, self.start[east])
        return west, east, shared

    def touching(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Pairs of pieces that share a side of a cell, one beside or above the other."""
        west, east, _ = self.beside()
        above = np.flatnonzero(self.stop[:-1] == self.start[1:])
        return np.concatenate([west, above]), np.concatenate([east, above + 1])

    def parts(self) -> tuple[int, NDArray[np.int32]]:
        """How many parts pieces of equal label hang together in, and (M,) the part of each piece."""
        one, other = self.touching()
        same = self.label[one] == self.label[other]
        return joined(len(self.label), one[same], other[same])

    def painted(self, label: NDArray[np.int32]) -> NDArray[np.int32]:
        """(H, W) int32: a map with the given label (M,) on each piece, and -1 elsewhere."""
        height, width = self.shape
        lengths = np.diff(np.column_stack([self.start, self.stop]).ravel(), prepend=0, append=width * (height + 1))
        values = np.full(len(lengths), -1, np.int32)
        values[1::2] = label
        return np.ascontiguousarray(np.repeat(values, lengths).reshape(width, height + 1)[:, :height].T)


def joined(count: int, one: NDArray[np.int64], other: NDArray[np.int64]) -> tuple[int, NDArray[np.int32]]:
    """Number of groups into which pairs join `count` things, and (count,) the group of each."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if count == 0:
        return 0, np.zeros(0, np.int32)
    links = coo_array((np.ones(len(one), np.int8), (one, other)), shape=(count, count))
    groups, group = connected_components(links, directed=False)
    return int(groups), group


def _adjacency(free: NDArray[np.bool_], labels: NDArray[np.int32]) -> NDArray[np.int64]:
    """(E, 2): pairs of regions that share a side, or of which one free part in no region joins both."""
    from scipy.sparse import coo_array

    n_regions = int(labels.max(initial=-1)) + 1
    pieces = Pieces.of(np.where(free & (labels < 0), np.int32(n_regions), labels))
    parts, part = pieces.parts()
    one, other = pieces.touching()
    in_one, in_other = pieces.label[one] < n_regions, pieces.label[other] < n_regions
    meet = in_one & in_other & (pieces.label[one] != pieces.label[other])
    pairs = np.column_stack([pieces.label[one[meet]], pieces.label[other[meet]]]).astype(np.int64)
    beyond = np.concatenate([part[one[in_other & ~in_one]], part[other[in_one & ~in_other]]])
    region = np.concatenate([pieces.label[other[in_other & ~in_one]], pieces.label[one[in_one & ~in_other]]])
    around = coo_array((np.ones(len(region), np.int64), (beyond, region)), shape=(parts, n_regions)).tocsr()
    through = np.column_stack((around.T @ around).nonzero()).astype(np.int64)
    pairs = np.sort(np.concatenate([pairs, through]), axis=1)
    return np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
