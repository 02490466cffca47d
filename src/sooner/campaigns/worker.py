"""The process that flies trials: rows come in as lines of JSON, answers go out as lines of JSON.

    python -m sooner.campaigns.worker PLACE PARENT

A trial is a pure function of its row and of the place, so nothing else passes between the processes: no pickles, no
state. `Slot` starts this process, watches it and ends it.
"""

from __future__ import annotations

import ctypes
import faulthandler
import json
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, TextIO

from sooner.campaigns.provenance import provenance
from sooner.campaigns.trial import Case, Place, Trial

__all__ = ["main"]

IDLE_S = 900.0

Fly = Callable[[Trial, Place], Mapping[str, Any]]


def main() -> None:
    """Fly trials until nobody sends any more."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what a trial prints is no answer
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the campaign, which ends us
    faulthandler.enable()
    _die_with(int(sys.argv[2]))
    rows: SimpleQueue[str] = SimpleQueue()
    threading.Thread(target=_read, args=(rows,), daemon=True).start()
    place = Place(**json.loads(sys.argv[1]))
    place = Place(place.function, place.folder, _data(place), tuple(place.data_files))
    _tell(answers, provenance(place))  # before anything of the study's own can fail
    if place.folder:
        sys.path.insert(0, place.folder)
    module, name = place.function.split(":")
    fly: Fly = getattr(import_module(module), name)
    _tell(answers, {"ready": True})
    while True:
        try:
            key, seed = json.loads(rows.get(timeout=IDLE_S))
        except Empty:  # a campaign that was killed on another machine may leave us here
            return
        _tell(answers, _flown(fly, Trial(Case.from_key(key), seed), place))


def _read(rows: SimpleQueue[str]) -> None:
    for row in sys.stdin:
        rows.put(row)
    os._exit(0)  # whoever sent rows is gone, even in the middle of a trial


def _die_with(parent: int) -> None:
    """On Linux the kernel ends us with our parent, even where a trial never lets go."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGKILL)
        if os.getppid() != parent:  # it went before we asked
            os._exit(0)


def _data(place: Place) -> str:
    """The folder of maps: where the campaign has it or, on another machine, where SOONER_DATA says."""
    here = os.environ.get("SOONER_DATA", "")
    if not place.data or Path(place.data).is_dir() or not here:
        return place.data
    below = Path(here) / Path(place.data).name
    return str(below if below.is_dir() else here)


def _flown(fly: Fly, trial: Trial, place: Place) -> dict[str, Any]:
    """Fly once, and measure what it took."""
    _forget_peak()
    wall, cpu = time.perf_counter(), time.process_time()
    try:
        said: dict[str, Any] = {"answer": json.dumps(_object(fly(trial, place)), default=_plain)}
    except MemoryError:
        said = {"ending": "memory", "reason": traceback.format_exc()}
    except Exception:
        said = {"ending": "error", "reason": traceback.format_exc()}
    return said | {
        "wall_s": time.perf_counter() - wall,
        "cpu_s": time.process_time() - cpu,
        "memory_mb": _peak_mb(),
    }


def _object(answer: Any) -> Mapping[str, Any]:
    if not isinstance(answer, Mapping):
        raise TypeError(f"the trial returned {type(answer).__name__}; expected an object, as {{'value': 1.5}}")
    return dict(answer)


def _plain(value: Any) -> Any:
    """Arrays and their numbers, as JSON has them."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} came; expected numbers, text, lists or objects with text as keys")


def _tell(answers: TextIO, said: Mapping[str, Any]) -> None:
    answers.write(json.dumps(said) + "\n")
    answers.flush()


def _forget_peak() -> None:
    """Where the system can, the peak of memory starts anew with each trial; elsewhere it is that of the process."""
    try:
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    except OSError:
        return


def _peak_mb() -> float:
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii", errors="replace")
        return int(status.partition("VmHWM:")[2].split()[0]) / 1024
    except (OSError, IndexError, ValueError):
        import psutil

        told = psutil.Process().memory_info()
        return float(getattr(told, "peak_wset", told.rss)) / 2**20


if __name__ == "__main__":
    main()
