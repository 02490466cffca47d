"""Reading: an ordinary file opened, its text, its lines, its TOML, or a DataFormatError with the reason."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from sooner.errors import DataFormatError, Fault

__all__ = ["MOST_BYTES_OF_TOML", "bytes_of", "lines_of", "opened", "read_toml", "text_of"]

MOST_BYTES_OF_TOML = 10_000_000


def read_toml(path: Path, expected: str) -> dict[str, Any]:
    """What a TOML file says.

    Parameters
    ----------
    path : Path
    expected : str          what the file should be, in words for who gave another: "expected a study in TOML"

    Raises
    ------
    DataFormatError         missing, unreadable, too large, not text, or not TOML

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "study.toml"
    >>> _ = path.write_text("trials = 20")
    >>> read_toml(path, "expected a study in TOML")
    {'trials': 20}
    """
    said = text_of(path, bytes_of(path, MOST_BYTES_OF_TOML, "10 MB", expected), expected)
    try:
        return tomllib.loads(said)
    except (ValueError, RecursionError) as error:  # plain ValueError: a number of thousands of digits
        raise DataFormatError(Fault(str(path), "", f"it is not TOML ({error})", expected)) from None


def bytes_of(path: Path, most_bytes: int, in_words: str, expected: str) -> bytes:
    """What a file holds, where that is not more than so many bytes."""
    with opened(path) as file:
        data = file.read(most_bytes + 1)
    if len(data) > most_bytes:
        raise DataFormatError(Fault(str(path), "", f"a file of more than {in_words} came", expected))
    return data


def text_of(path: Path, data: bytes, expected: str) -> str:
    """What a file holds, as text: UTF-8, with or without a byte order mark."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise DataFormatError(Fault(str(path), "", "something that is not text came", expected)) from None


def lines_of(path: Path, data: bytes, expected: str) -> list[tuple[int, str]]:
    """(number, text) of every line of a file that is not blank, of which there must be one."""
    numbered = enumerate(text_of(path, data, expected).splitlines(), start=1)
    found = [(number, line) for number, line in numbered if line.strip()]
    if not found:
        raise DataFormatError(Fault(str(path), "", "an empty file came", expected))
    return found


@contextmanager
def opened(path: Path) -> Iterator[BinaryIO]:
    """An ordinary file opened for reading; DataFormatError, with the reason, where that cannot be."""
    handle: BinaryIO | None = None
    try:
        if path.is_dir():
            came = "a folder came"
        elif path.exists() and not path.is_file():
            came = "something that is not an ordinary file came"
        else:
            handle = path.open("rb")
    except FileNotFoundError:
        came = "there is no such file"
    except OSError as error:
        came = f"it cannot be read ({error.strerror or error})"
    except ValueError as error:  # a NUL in the name
        came = f"it cannot be read ({error})"
    if handle is None:
        raise DataFormatError(Fault(str(path), "", came, "expected a file that can be read"))
    with handle:
        yield handle
