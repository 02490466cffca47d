"""Natural environments: ground cut from noise, with obstacles of few or many shapes [Kuhlman2017, sec. 6.1]."""

from __future__ import annotations

import hashlib
import json
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from io import BytesIO
from itertools import islice
from math import isqrt, prod
from pathlib import Path
from tokenize import TokenError
from typing import IO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault, InvalidProblemError
from sooner.grid import Grid
from sooner.grid.grid import MAX_CELLS
from sooner.scenarios.simplex_noise import elevation

__all__ = [
    "EXPERIMENT_2_CELLS",
    "NATURAL_KINDS",
    "NaturalEnvironment",
    "Terrain",
    "downsampled",
    "experiment_2",
    "natural_environment",
    "natural_environments",
    "starts",
]

CELL_M = 2.2
FREE_SHARE = 0.66  # Algorithm 4, line 6
TOLERANCE = 0.9  # line 8: least free space over FREE_SHARE; the paper says no number
SMALLEST_OBSTACLE = 25  # line 9: cells of CELL_M; the paper says no number
LOW_ENTROPY_SHARE = 0.5  # sec. 7
LOW_ENTROPY_KIND = {"low": "vlf", "med": "vlf", "high": "low", "vhf": "med"}  # sec. 7
LOW_ENTROPY_SEED = 1_000_000  # added to the seed, so that low entropy does not follow the obstacles
LOW_ENTROPY_THETA = 0.85**2 / (0.85**2 + 0.15**2)  # 0.97: after two hits with p_d = 0.85, p_f = 0.15, eq. (14)
PATIENCE = 1000  # seeds in a row without an accepted environment, before we say that there is none
EXPERIMENT_2_CELLS = (4608, 10368, 20000, 39200, 80000, 180000, 320000)  # sec. 7.2

# What zip files, JSON and NumPy headers raise when they are not what they should be.
UNREADABLE = (
    *(ValueError, KeyError, TypeError, EOFError, RuntimeError, MemoryError, NotImplementedError),
    *(SyntaxError, OverflowError, TokenError, zipfile.BadZipFile, zlib.error),
)


@dataclass(frozen=True)
class Terrain:
    """Parameters of one kind of ground.

    Parameters
    ----------
    frequencies : (float, float)    f1 and f2, per cell
    weights : (float, float)        w1 and w2
    shape : (int, int)              H and W
    cell_m : float                  metres
    """

    frequencies: tuple[float, float]
    weights: tuple[float, float] = (1.0, 0.25)
    shape: tuple[int, int] = (100, 200)
    cell_m: float = CELL_M


# From few big shapes to many small ones [Kuhlman2017, sec. 6.1]; "fine" is Experiment 2's [sec. 7.2].
NATURAL_KINDS: dict[str, Terrain] = {
    "vlf": Terrain((0.015, 0.05)),
    "low": Terrain((0.03, 0.1)),
    "med": Terrain((0.045, 0.15)),
    "high": Terrain((0.06, 0.2)),
    "vhf": Terrain((0.075, 0.25)),  # printed 0.75: a misprint
    "fine": Terrain((0.0075, 0.1), (1.0, 0.0625), (400, 800), CELL_M / 4),
}


@dataclass(frozen=True, eq=False)
class NaturalEnvironment:
    """Ground to search, and where there is less to learn.

    Parameters
    ----------
    kind : str                          a key of `NATURAL_KINDS`
    seed : int                          of its noise
    grid : Grid                         square cells with 8 neighbours; obstacles
    low_entropy : (H, W) bool or None   cells that were looked at before; None where none was

    Raises
    ------
    InvalidProblemError                 if there is no such kind or seed, no free cell, or the shapes differ
    """

    kind: str
    seed: int
    grid: Grid
    low_entropy: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        _terrain(self.kind)
        if self.seed < 1:
            raise InvalidProblemError(f"seed {self.seed} came; seeds count from 1")
        if not self.grid.passable.any():
            raise InvalidProblemError("every cell came as an obstacle; expected at least one free cell")
        if self.low_entropy is not None and self.low_entropy.shape != self.grid.shape:
            raise InvalidProblemError(
                f"low entropy of shape {self.low_entropy.shape} came; the grid has {self.grid.shape}"
            )

    @property
    def free(self) -> NDArray[np.bool_]:
        """(H, W) bool: cells without an obstacle."""
        return self.grid.passable.reshape(self.grid.shape)

    @property
    def theta(self) -> NDArray[np.float64]:
        """(H, W) float: P(a target is in this cell) before the search, each cell for itself.

        0.5 everywhere, but 0.97 in cells of low entropy: as after two hits, (nz0, nz1) = (0, 2), of a sensor with
        p_d = 0.85 and p_f = 0.15 [Kuhlman2017, eq. (14) and sec. 7].
        """
        low = np.zeros(self.grid.shape, bool) if self.low_entropy is None else self.low_entropy
        return np.where(low, LOW_ENTROPY_THETA, 0.5)

    def save(self, path: Path) -> None:
        """Write as compressed NumPy arrays with a checksum; the same environment is the same bytes."""
        arrays = {
            "about": np.frombuffer(self._about().encode(), np.uint8),
            "obstacles": (~self.free).astype(np.uint8),
            "checksum": np.frombuffer(self.checksum().encode(), np.uint8),
        }
        if self.low_entropy is not None:
            arrays["low_entropy"] = self.low_entropy.astype(np.uint8)
        content = BytesIO()
        np.savez_compressed(content, **arrays)  # type: ignore[arg-type]
        Path(path).write_bytes(content.getvalue())

    @classmethod
    def load(cls, path: Path) -> NaturalEnvironment:
        """Read what `save` wrote.

        Raises
        ------
        DataFormatError    if the file is no such thing, too large, or was changed since
        OSError            if it cannot be read
        """
        with Path(path).open("rb") as file:
            try:
                return _read(file)
            except (*UNREADABLE, OSError) as error:  # a damaged archive may point to before its own beginning
                came = f"came a file that cannot be used ({error})"
                expected = "expected an environment as NaturalEnvironment.save writes it"
                raise DataFormatError(Fault(str(path), "", came, expected)) from None

    def checksum(self) -> str:
        """SHA-256 of everything that makes up the environment, in hexadecimal."""
        whole = hashlib.sha256(self._about().encode())
        whole.update(np.packbits(self.free).tobytes())
        if self.low_entropy is not None:
            whole.update(b"low entropy" + np.packbits(self.low_entropy).tobytes())
        return whole.hexdigest()

    def _about(self) -> str:
        rows, cols = self.grid.shape
        cell_m = float(self.grid.cell_m)
        return json.dumps({"kind": self.kind, "seed": self.seed, "rows": rows, "cols": cols, "cell_m": cell_m})


def natural_environment(
    kind: str,
    number: int = 1,
    shape: tuple[int, int] | None = None,
    cell_m: float | None = None,
    nonuniform: bool = False,
) -> NaturalEnvironment:
    """The `number`-th environment of a kind that Algorithm 4 accepts, as seeds count 1, 2, ...

    Parameters are those of `natural_environments`.

    Examples
    --------
    >>> ground = natural_environment("low", 2)
    >>> ground.seed, ground.grid.shape, float(ground.free.mean().round(3))
    (3, (100, 200), 0.608)
    """
    if number < 1:
        raise InvalidProblemError(f"environment number {number} came; the first is number 1")
    return next(islice(natural_environments(kind, shape, cell_m, nonuniform), number - 1, None))


def natural_environments(
    kind: str, shape: tuple[int, int] | None = None, cell_m: float | None = None, nonuniform: bool = False
) -> Iterator[NaturalEnvironment]:
    """Environments of one kind, without end: Algorithm 4 [Kuhlman2017, sec. 6.1].

    Noise belongs to metres: more cells of the kind's own size are more ground of the same character, and smaller
    cells draw the same ground more finely, with f / r per cell and r^2 as many cells in the smallest obstacle.

    Parameters
    ----------
    kind : str               a key of `NATURAL_KINDS`
    shape : (int, int)       H and W; the paper's, if left out
    cell_m : float           metres; the paper's, if left out
    nonuniform : bool        with cells of low entropy, for the kinds for which the paper says how

    Raises
    ------
    InvalidProblemError      if there is no such kind or size, or if a thousand seeds in a row are turned down

    Notes
    -----
    All kinds begin at the noise's origin, so one seed draws one ground for all of them, seen from nearer or farther.
    Compare kinds over many seeds, not seed by seed.
    """
    terrain = _at_size(kind, shape, cell_m)
    if nonuniform and kind not in LOW_ENTROPY_KIND:
        raise InvalidProblemError(
            f"a nonuniform {kind!r} came; cells of low entropy go with {', '.join(map(repr, LOW_ENTROPY_KIND))}"
        )
    return _environments(kind, terrain, nonuniform)


def _environments(kind: str, terrain: Terrain, nonuniform: bool) -> Iterator[NaturalEnvironment]:
    smallest = SMALLEST_OBSTACLE * (CELL_M / terrain.cell_m) ** 2
    seed, accepted = 0, 0
    while (seed := seed + 1) <= accepted + PATIENCE:
        noise = elevation(terrain.shape, terrain.frequencies, terrain.weights, seed)
        free = _largest_component(noise <= np.quantile(noise, FREE_SHARE))
        if free.mean() < TOLERANCE * FREE_SHARE:
            continue
        accepted = seed
        free = _without_small_obstacles(free, smallest)
        low_entropy = _low_entropy(kind, seed, terrain) if nonuniform else None
        yield NaturalEnvironment(kind, seed, Grid(terrain.shape, "square8", terrain.cell_m, ~free), low_entropy)
    raise InvalidProblemError(f"{PATIENCE} seeds in a row left too little free space on a {terrain.shape} map")


def _at_size(kind: str, shape: tuple[int, int] | None, cell_m: float | None) -> Terrain:
    terrain = _terrain(kind)
    grid = Grid(shape or terrain.shape, cell_m=terrain.cell_m if cell_m is None else cell_m)  # checks both
    finer = grid.cell_m / terrain.cell_m
    f1, f2 = terrain.frequencies
    return replace(terrain, shape=grid.shape, cell_m=grid.cell_m, frequencies=(f1 * finer, f2 * finer))


def _terrain(kind: str) -> Terrain:
    if kind not in NATURAL_KINDS:
        raise InvalidProblemError(f"environment {kind!r} came; expected one of {', '.join(NATURAL_KINDS)}")
    return NATURAL_KINDS[kind]


def _largest_component(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(H, W) bool: of the free cells joined by their sides, those in the largest group."""
    from scipy.ndimage import label

    groups, count = label(free)
    sizes = np.bincount(groups.ravel(), minlength=count + 1)
    sizes[0] = 0
    largest: NDArray[np.bool_] = free & (groups == sizes.argmax())
    return largest


def _without_small_obstacles(free: NDArray[np.bool_], smallest: float) -> NDArray[np.bool_]:
    """(H, W) bool: free cells, and those of obstacles (joined by sides or corners) of fewer than `smallest` cells."""
    from scipy.ndimage import label

    obstacles, count = label(~free, np.ones((3, 3)))
    sizes = np.bincount(obstacles.ravel(), minlength=count + 1)
    small: NDArray[np.bool_] = sizes < smallest
    small[0] = True  # what is free already
    opened: NDArray[np.bool_] = small[obstacles]
    return opened


def _low_entropy(kind: str, seed: int, terrain: Terrain) -> NDArray[np.bool_]:
    """(H, W) bool: the lower half of a noise of its own seed, and often of a lower frequency."""
    coarse = _at_size(LOW_ENTROPY_KIND[kind], terrain.shape, terrain.cell_m)
    noise = elevation(coarse.shape, coarse.frequencies, coarse.weights, seed + LOW_ENTROPY_SEED)
    low: NDArray[np.bool_] = noise <= np.quantile(noise, LOW_ENTROPY_SHARE)
    return low


def experiment_2(number: int, n_cells: int) -> NaturalEnvironment:
    """The same ground in more or fewer cells [Kuhlman2017, sec. 7.2]: the `number`-th "fine" one, downsampled.

    Examples
    --------
    >>> coarse = experiment_2(1, 4608)
    >>> coarse.grid.shape, round(coarse.grid.cell_m, 3)
    ((48, 96), 4.583)
    """
    if n_cells not in EXPERIMENT_2_CELLS:
        raise InvalidProblemError(f"{n_cells} cells came; expected one of {', '.join(map(str, EXPERIMENT_2_CELLS))}")
    height = isqrt(n_cells // 2)
    return downsampled(natural_environment("fine", number), (height, 2 * height))


def downsampled(environment: NaturalEnvironment, shape: tuple[int, int]) -> NaturalEnvironment:
    """The same ground in fewer and larger cells.

    A cell becomes what most of its ground was, counting parts of old cells by their area; where both have half,
    what the old cell under its centre was (south-east of it, if it lies on a border). Then, as in Algorithm 4,
    what is cut off from the largest free component becomes obstacle, and obstacles smaller than 25 cells of 2.2 m
    go. The paper says "downsampled" and no more.

    Raises
    ------
    InvalidProblemError    if the new shape has more rows, or another ratio of rows to columns
    """
    (old_rows, old_cols), (rows, cols) = environment.grid.shape, shape
    if not 1 <= rows <= old_rows or rows * old_cols != cols * old_rows:
        raise InvalidProblemError(f"shape {shape} came; expected {old_rows} x {old_cols} or fewer in the same ratio")
    cell_m = environment.grid.cell_m * old_rows / rows
    free = _largest_component(_majority(environment.free, shape))
    free = _without_small_obstacles(free, SMALLEST_OBSTACLE * (CELL_M / cell_m) ** 2)
    low = environment.low_entropy
    grid = Grid(shape, "square8", cell_m, ~free)
    return replace(environment, grid=grid, low_entropy=None if low is None else _majority(low, shape))


def _majority(flags: NDArray[np.bool_], shape: tuple[int, int]) -> NDArray[np.bool_]:
    down, across = (_overlaps(old, new) for old, new in zip(flags.shape, shape, strict=True))
    for_it = down @ flags.astype(np.float64) @ across.T  # whole numbers throughout, and so exact
    half = flags.size / 2  # one new cell, in the unit of area that both old and new cells are whole numbers of
    rows, cols = ((2 * np.arange(new) + 1) * old // (2 * new) for old, new in zip(flags.shape, shape, strict=True))
    return np.where(for_it == half, flags[np.ix_(rows, cols)], for_it > half)


def _overlaps(old: int, new: int) -> NDArray[np.float64]:
    """(new, old) float: length that new and old intervals of one line share, where the line is old * new long."""
    ours, theirs = old * np.arange(new)[:, None], new * np.arange(old)
    shared: NDArray[np.float64] = np.minimum(ours + old, theirs + new) - np.maximum(ours, theirs).astype(np.float64)
    return shared.clip(0.0)


def starts(environment: NaturalEnvironment, count: int, seed: int) -> tuple[tuple[int, int], ...]:
    """`count` different free cells to start from, each [row, col] as likely as any other.

    Examples
    --------
    >>> starts(natural_environment("low"), count=2, seed=1)
    ((90, 33), (30, 96))
    """
    free = np.flatnonzero(environment.grid.passable)
    if not 0 <= count <= free.size or seed < 0:
        raise InvalidProblemError(f"{count} starts of seed {seed} came; there are {free.size} free cells, seeds from 0")
    drawn = np.random.default_rng((environment.seed, seed)).choice(free, count, replace=False)
    return tuple(environment.grid.cell(index) for index in drawn)


def _read(file: IO[bytes]) -> NaturalEnvironment:
    """What a file of `save` holds; raises any of UNREADABLE where it is none."""
    with zipfile.ZipFile(file) as archive:
        arrays = {name: _member(archive, name) for name in archive.namelist()}
    about = json.loads(arrays["about.npy"].tobytes())
    kind, seed, cell_m = about["kind"], about["seed"], about["cell_m"]
    if not (type(kind) is str and type(seed) is int and type(cell_m) is float):
        raise ValueError("kind, seed or cell_m is of the wrong type")
    obstacles, low = _flags(arrays["obstacles.npy"]), arrays.get("low_entropy.npy")
    grid = Grid(obstacles.shape, "square8", cell_m, obstacles)
    environment = NaturalEnvironment(kind, seed, grid, None if low is None else _flags(low))
    if arrays["checksum.npy"].tobytes() != environment.checksum().encode():
        raise ValueError("the checksum does not fit: the file was changed since it was saved")
    return environment


def _member(archive: zipfile.ZipFile, name: str) -> NDArray[np.uint8]:
    """One array of bytes, not a byte more of which is read than its header says."""
    most = {"about.npy": 1000, "checksum.npy": 64, "obstacles.npy": MAX_CELLS, "low_entropy.npy": MAX_CELLS}
    with archive.open(name) as stream:
        if npy.read_magic(stream) != (1, 0):
            raise ValueError(f"{name} is of another NumPy format than 1.0")
        shape, by_columns, dtype = npy.read_array_header_1_0(stream)
        size = prod(shape)
        if dtype != np.uint8 or by_columns or min(shape, default=0) < 0 or size > most[name]:
            raise ValueError(f"{name} holds {shape} of {dtype}")
        content = stream.read(size + 1)
    if len(content) != size:
        raise ValueError(f"{name} says {size} bytes and has {'more' if len(content) > size else len(content)}")
    return np.frombuffer(content, np.uint8).reshape(shape)


def _flags(array: NDArray[np.uint8]) -> NDArray[np.bool_]:
    if array.ndim != 2 or array.size == 0 or array.max() > 1:
        raise ValueError(f"an array of shape {array.shape} and values up to {array.max(initial=0)} is no map of flags")
    return array.astype(bool)
