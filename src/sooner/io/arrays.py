"""Arrays in files: an .npz of plain numbers, of which nothing is ever run, and none is larger than it says."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Collection, Mapping
from math import inf, prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault, InvalidProblemError
from sooner.io.reading import opened

__all__ = ["Arrays", "array_like", "arrays_npz", "has_array", "read_arrays"]

MOST_BYTES = 2_000_000_000  # of all arrays together, unpacked
Arrays = dict[str, NDArray[Any]]


def arrays_npz(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Arrays as an .npz."""
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)  # type: ignore[arg-type]
    return file.getvalue()


def has_array(path: Path, name: str) -> bool:
    """Whether a file is an .npz with an array of that name."""
    try:
        with opened(path) as file, zipfile.ZipFile(file) as archive:
            return f"{name}.npy" in archive.namelist()
    except (OSError, zipfile.BadZipFile, NotImplementedError, RuntimeError):
        return False


def read_arrays(path: Path, needed: Collection[str], possible: Collection[str], expected: str) -> Arrays:
    """The arrays of an .npz.

    Parameters
    ----------
    path : Path
    needed, possible : names     what must be in it, and what else may be
    expected : str               in words for who gave another file: "expected an episode that sooner wrote"

    Raises
    ------
    DataFormatError              missing, too large, no .npz, or with parts that are missing, strange, or no numbers

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "numbers.npz"
    >>> _ = path.write_bytes(arrays_npz({"primes": np.array([2, 3, 5])}))
    >>> read_arrays(path, ["primes"], [], "expected numbers")
    {'primes': array([2, 3, 5])}
    """
    names, arrays = {*needed, *possible}, {}
    try:
        with opened(path) as file, zipfile.ZipFile(file) as archive:
            parts = archive.infolist()
            if len(parts) > len(names) or sum(part.file_size for part in parts) > MOST_BYTES:
                came = f"{len(parts)} parts, or more than {MOST_BYTES:g} bytes, came"
                raise DataFormatError(Fault(str(path), "", came, expected))
            for part in parts:
                name = part.filename.removesuffix(".npy")
                if name not in names:
                    raise DataFormatError(Fault(str(path), name, "a part of that name came", expected))
                arrays[name] = _array(path, name, archive.read(part), expected)
    except OSError as error:
        came = f"it cannot be read ({error.strerror or error})"
        raise DataFormatError(Fault(str(path), "", came, expected)) from None
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError) as error:
        raise DataFormatError(Fault(str(path), "", f"it is not an .npz ({error})", expected)) from None
    missing = [name for name in needed if name not in arrays]
    if missing:
        raise DataFormatError(*(Fault(str(path), name, "it is missing", expected) for name in missing))
    return arrays


def _array(path: Path, name: str, data: bytes, expected: str) -> NDArray[Any]:
    file = io.BytesIO(data)
    try:
        version = npy.read_magic(file)
        if version not in ((1, 0), (2, 0)):
            raise ValueError(f"version {version}")
        header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, fortran, kind = header(file)
        sound = kind.kind in "biuf" and min(shape, default=0) >= 0 and not (fortran and len(shape) > 1)
        if not sound or prod(shape) * kind.itemsize != len(data) - file.tell():
            raise ValueError(f"shape {shape} of {kind}")
    except ValueError as error:
        raise DataFormatError(Fault(str(path), name, f"it is no array of numbers ({error})", expected)) from None
    return np.frombuffer(data, kind, offset=file.tell()).reshape(shape).copy()


def array_like(
    arrays: Arrays, name: str, kind: str, shape: tuple[int | None, ...], least: float = -inf, most: float = inf
) -> NDArray[Any]:
    """An array of that kind ("i", "f" or "b") and shape (None: any length), its numbers finite and in that range.

    Raises
    ------
    InvalidProblemError      if it is another

    Examples
    --------
    >>> array_like({"ages": np.array([3, 40])}, "ages", "i", (None,), least=0)
    array([ 3, 40])
    """
    array = arrays[name]
    fits = array.ndim == len(shape) and all(
        want is None or have == want for have, want in zip(array.shape, shape, strict=True)
    )
    if array.dtype.kind != kind or not fits:
        raise InvalidProblemError(f"{name} of type {array.dtype} and shape {array.shape} came; expected {shape}")
    if array.size and kind != "b" and not (least <= array.min() and array.max() <= most and np.isfinite(array).all()):
        raise InvalidProblemError(f"{name} with numbers that are not between {least} and {most} came")
    return array
