"""Writing: whole files or none, and nobody else's file is replaced.

Files are written beside their place, flushed to the disk, and renamed into it. A folder that sooner writes to keeps
`.sooner-files.json`, the checksums of what sooner put there. A file may be replaced if it still is what sooner
wrote; one that came from elsewhere, or that somebody has edited since, is left alone unless `force` says otherwise.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from sooner.errors import DataFormatError, Fault

__all__ = ["Folder"]

LEDGER = ".sooner-files.json"
_TEMPORARY = ".sooner-"


@dataclass(frozen=True)
class Folder:
    """A folder to write results to.

    Parameters
    ----------
    path : Path
    force : bool      replace files even where sooner did not write them

    Examples
    --------
    >>> import tempfile
    >>> folder = Folder(Path(tempfile.mkdtemp()) / "new")
    >>> folder.write({"plan.csv": b"row,col"})
    >>> (folder.path / "plan.csv").read_text()
    'row,col'
    """

    path: Path
    force: bool = False

    def check(self, *names: str) -> None:
        """Raise DataFormatError for every file of these names that must not be written; nothing is made yet."""
        there = next(place for place in (self.path, *self.path.absolute().parents) if place.exists())
        if not there.is_dir():
            raise _refusal(self.path, f"{there} is not a folder")
        try:
            with tempfile.TemporaryFile(dir=there):
                pass
        except OSError as error:
            raise _refusal(self.path, f"{there} cannot be written to ({error.strerror or error})") from None
        with _alone_in(there):
            self._check(names)

    def _check(self, names: Iterable[str]) -> None:
        ledger = self._ledger()
        faults = [fault for name in names if (fault := self._fault(name, ledger)) is not None]
        if faults:
            raise DataFormatError(*faults)

    def beside(self, name: str) -> Path:
        """A place beside a file's own, to make a large one before `write` puts it there; swept up if we are killed."""
        return self.path / f"{_TEMPORARY}{os.getpid()}-{name}.tmp"

    def write(self, files: Mapping[str, bytes | Path]) -> None:
        """Write all of these files, or, where one of them cannot be written, none.

        Parameters
        ----------
        files : mapping        name and what it holds, or where it was made `beside`

        Raises
        ------
        DataFormatError        where a file must not be replaced, or the disk refuses
        """
        self.check(*files)
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _refusal(self.path, f"writing failed ({error.strerror or error})") from None
        with _alone_in(self.path):
            self._write(files)

    def _write(self, files: Mapping[str, bytes | Path]) -> None:
        written = {name: content for name, content in files.items() if isinstance(content, Path)}
        try:
            self._check(files)
            self._sweep()
            for name, content in files.items():
                if not isinstance(content, Path):
                    written[name] = self._beside(name, content)
            ledger = self._ledger()
            for name, content in files.items():  # before the renames: a crash between them leaves files known as ours
                ledger[name] = [*ledger.get(name, [])[-1:], _checksum(content)]
            beside = self._beside(LEDGER, (json.dumps(ledger, indent=1, sort_keys=True) + "\n").encode())
            beside.replace(self.path / LEDGER)
            for name in list(written):
                written.pop(name).replace(self.path / name)
            self._flush()
        except OSError as error:
            raise _refusal(self.path, f"writing failed ({error.strerror or error})") from None
        finally:
            for leftover in written.values():
                leftover.unlink(missing_ok=True)

    def _fault(self, name: str, ledger: dict[str, list[str]]) -> Fault | None:
        place = self.path / name
        if place.is_dir():
            return Fault(str(place), "", "a folder of that name is in the way", "move it, or give another --out")
        if self.force or not place.exists():
            return None
        if name not in ledger:
            came = "a file of that name is there, and sooner did not write it"
        elif _checksum(place) not in ledger[name]:
            came = "this file has been changed since sooner wrote it"
        else:
            return None
        return Fault(str(place), "", came, "move it, give another --out, or say --force to replace it")

    def _ledger(self) -> dict[str, list[str]]:
        try:
            read = json.loads((self.path / LEDGER).read_text(encoding="utf-8"))
            return {str(name): [str(sum_) for sum_ in sums] for name, sums in read.items()}
        except (OSError, ValueError, AttributeError, TypeError):
            return {}

    def _beside(self, name: str, content: bytes) -> Path:
        beside = self.beside(name)
        try:
            with beside.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        except BaseException:
            beside.unlink(missing_ok=True)
            raise
        return beside

    def _sweep(self) -> None:
        """Remove what a killed run of sooner left beside."""
        for leftover in self.path.glob(f"{_TEMPORARY}*.tmp"):
            owner = leftover.name.removeprefix(_TEMPORARY).partition("-")[0]
            if owner.isdigit() and int(owner) != os.getpid() and not _is_running(int(owner)):
                leftover.unlink(missing_ok=True)

    def _flush(self) -> None:
        with contextlib.suppress(OSError):  # some systems cannot flush a folder
            handle = os.open(self.path, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)


@contextlib.contextmanager
def _alone_in(folder: Path) -> Iterator[None]:
    """While this lasts, another sooner that writes into the folder waits (where the system has such locks)."""
    try:
        import fcntl
    except ImportError:
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        with contextlib.suppress(OSError):  # some network drives have no locks
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def _refusal(path: Path, came: str) -> DataFormatError:
    return DataFormatError(Fault(str(path), "", came, "expected a folder that can be written to; give another --out"))


def _checksum(content: bytes | Path) -> str:
    if isinstance(content, bytes):
        return hashlib.sha256(content).hexdigest()
    with content.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _is_running(process: int) -> bool:
    if os.name != "posix":  # elsewhere signal 0 is not a question
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
