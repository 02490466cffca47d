"""What a result was made by: commit, source, packages, processor."""

from __future__ import annotations

import hashlib
import os
import platform
import re
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from functools import cache
from importlib.machinery import PathFinder
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sooner.campaigns.trial import Place
from sooner.errors import DataFormatError, Fault

__all__ = ["commit", "maps", "processor", "provenance", "same_source", "sources"]

PACKAGE = Path(__file__).resolve().parents[1]
TELLING = (
    "cli/*", "console/*", "plotting/*", "campaigns/*", "experiments/compare.py", "experiments/figures.py",
    "experiments/published.py", "experiments/reproduce.py", "experiments/tables.py", "experiments/*/claims.py",
    "experiments/*/figure*.py",
)  # fmt: skip
"""Modules that tell of results, or carry them, and decide none."""
ASIDE = (".*", "__pycache__", "node_modules", "*-results")
"""Folders below a study that decide no result."""
MOST_FILES, MOST_BYTES, MOST_ENTRIES = 5_000, 100_000_000, 200_000


def provenance(place: Place) -> dict[str, Any]:
    """What decides a result, and where it was made.

    `source` is a digest of what `sources` names, `data` one of the maps: two results belong together where both are the
    same. The rest is told for the reader.

    Raises
    ------
    DataFormatError      too many Python files lie below the folder of the study
    """
    return {
        "commit": commit(),
        "source": _digest(sources(place)),
        "data": _digest(maps(place)),
        "python": platform.python_version(),
        "packages": _packages(),
        "processor": processor(),
        "machine": platform.node(),
    }


def same_source(ours: dict[str, Any], theirs: dict[str, Any]) -> bool:
    """Whether results of the two may stand in one table."""
    return all(ours.get(key) == theirs.get(key) for key in ("source", "data"))


def sources(place: Place) -> dict[str, bytes]:
    """The Python files that can decide a result, each with a digest of what it holds.

    The package's own; those below the folder of the study, but for hidden folders, virtual environments and results;
    and, where the trial's module or a planner's lies elsewhere, the package that it belongs to.
    """
    files = {f"sooner's own {name}": file for name, file in _below(PACKAGE) if not _matches(name, TELLING)}
    if place.folder:
        files |= {name: file for name, file in _below(Path(place.folder)) if PACKAGE not in file.parents}
    known = set(files.values())
    for module in (place.function.partition(":")[0], *place.modules):
        for name, file in _of_module(module, place.folder):
            if file not in known:
                files[name] = file
    return _digests(files, place.folder)


def maps(place: Place) -> dict[str, bytes]:
    """The files of maps and missions that can decide a result, each with a digest of what it holds."""
    folder = Path(place.data or place.folder or os.devnull)
    found = [file for pattern in place.data_files for file in sorted(folder.glob(pattern)) if file.is_file()]
    return {file.relative_to(folder).as_posix(): hashlib.sha256(file.read_bytes()).digest() for file in found}


def _matches(name: str, patterns: Sequence[str]) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)


def _below(folder: Path) -> Iterator[tuple[str, Path]]:
    """Python files below a folder, by name there; folders that are hidden, an environment or results stay aside."""
    been: set[str] = set()
    looked = 0
    for here, folders, files in os.walk(folder, followlinks=True):
        real = os.path.realpath(here)
        looked += len(folders) + len(files)
        if real in been or (been and "pyvenv.cfg" in files):
            folders.clear()
            continue
        if looked > MOST_ENTRIES:
            raise _too_many(folder, f"more than {MOST_ENTRIES:,} files lie below it")
        been.add(real)
        folders[:] = sorted(name for name in folders if not _matches(name, ASIDE))
        for name in sorted(files):
            file = Path(here) / name
            if name.endswith(".py") and file.is_file():
                yield file.relative_to(folder).as_posix(), file


def _of_module(module: str, folder: str) -> Iterator[tuple[str, Path]]:
    """Files of the package or module that this name begins with, found as a worker would; it is not loaded."""
    top = module.partition(".")[0]
    if top == PACKAGE.name:
        return
    try:
        spec = (PathFinder.find_spec(top, [folder]) if folder else None) or find_spec(top)
    except (ImportError, ValueError, OSError):
        return
    if spec is None:
        return
    for place in spec.submodule_search_locations or ():
        yield from ((f"{top}/{name}", file) for name, file in _below(Path(place)))
    if spec.origin and Path(spec.origin).is_file() and not spec.submodule_search_locations:
        yield Path(spec.origin).name, Path(spec.origin)


def _digests(files: Mapping[str, Path], folder: str) -> dict[str, bytes]:
    if len(files) > MOST_FILES:
        raise _too_many(folder, f"it and its modules hold {len(files):,} Python files; at most {MOST_FILES:,} are read")
    found, left = {}, MOST_BYTES
    for name, file in files.items():
        held = file.read_bytes()
        found[name] = hashlib.sha256(held).digest()
        left -= len(held)
        if left < 0:
            raise _too_many(folder, f"its Python files hold more than {MOST_BYTES // 10**6} MB")
    return found


def _too_many(folder: str | Path, came: str) -> DataFormatError:
    return DataFormatError(Fault(str(folder), "", came, "expected the study in a folder of its own"))


def _digest(files: Mapping[str, bytes]) -> str:
    """Of all these files: their names and what they hold."""
    whole = hashlib.sha256()
    for name in sorted(files):
        whole.update(f"{name}\0".encode("utf-8", "surrogateescape") + files[name])
    return whole.hexdigest()[:16]


@cache
def _packages() -> dict[str, str]:
    """Versions of what sooner needs to run, where installed."""
    try:
        wanted = requires("sooner") or []
    except PackageNotFoundError:
        wanted = []
    found = {}
    for name in sorted({re.split(r"[^\w.-]", line, maxsplit=1)[0] for line in wanted} | {"llvmlite"}):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


@cache
def commit() -> str:
    """What ran: the commit of this checkout, with + where its source has changed since; "" outside a checkout."""
    root = PACKAGE.parents[1]
    if PACKAGE.parent.name != "src":  # installed: a repository around it is somebody else's
        return ""
    head = _git(root, ["rev-parse", "--short=12", "HEAD"])
    changed = head and _git(root, ["status", "--porcelain", "--untracked-files=no", "--", "src"])
    return head + "+" if changed else head


def _git(root: Path, arguments: Sequence[str]) -> str:
    try:
        done = subprocess.run(["git", "-C", str(root), *arguments], capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


@cache
def processor() -> str:
    """Name of the processor, and how many of its cores this process may use."""
    name = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        lines = cpuinfo.read_text(encoding="utf-8", errors="replace").splitlines()
        name = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), name)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return f"{name}, {cores} cores"
