"""What a result was made by: commit, source, packages, processor."""

from __future__ import annotations

import hashlib
import os
import platform
import re
import subprocess
from collections.abc import Sequence
from fnmatch import fnmatchcase
from functools import cache
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from typing import Any

from sooner.campaigns.trial import Place

__all__ = ["commit", "processor", "provenance", "same_source"]

PACKAGE = Path(__file__).resolve().parents[1]
TELLING = (
    "cli/*", "console/*", "plotting/*", "campaigns/*", "experiments/compare.py", "experiments/published.py",
    "experiments/reproduce.py", "experiments/tables.py", "experiments/*/claims.py", "experiments/*/figures.py",
)  # fmt: skip
"""Modules that tell of results, or carry them, and decide none."""


def provenance(place: Place) -> dict[str, Any]:
    """What decides a result, and where it was made.

    `source` is a digest of the package's modules that can decide a result and of those beside the study, `data` one of
    the maps: two results belong together where both are the same. The rest is told for the reader.
    """
    maps = Path(place.data or place.folder or os.devnull)
    return {
        "commit": commit(),
        "source": _digest((PACKAGE, "**/*.py"), (Path(place.folder or os.devnull), "*.py")),
        "data": _digest(*((maps, pattern) for pattern in place.data_files)),
        "python": platform.python_version(),
        "packages": _packages(),
        "processor": processor(),
        "machine": platform.node(),
    }


def same_source(ours: dict[str, Any], theirs: dict[str, Any]) -> bool:
    """Whether results of the two may stand in one table."""
    return all(ours.get(key) == theirs.get(key) for key in ("source", "data"))


def _digest(*wanted: tuple[Path, str]) -> str:
    """Of all files that match a pattern below its folder: their names and what they hold."""
    whole = hashlib.sha256()
    for folder, pattern in wanted:
        for file in sorted(file for file in folder.glob(pattern) if file.is_file()):
            name = file.relative_to(folder).as_posix()
            if folder == PACKAGE and any(fnmatchcase(name, pattern) for pattern in TELLING):
                continue
            whole.update(f"{name}\0".encode() + hashlib.sha256(file.read_bytes()).digest())
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
