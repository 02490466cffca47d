"""The process that flies trials: rows come in as lines of JSON, answers go out as lines of JSON.

    python -m sooner.campaigns.worker PLACE PARENT

First it says what it is, then whether it is ready, then it answers each row. A row without a seed rehearses planners:
the answer names those that cannot be made.

A trial is a pure function of its row and of the place, so nothing else passes between the processes: no pickles, no
state. `Slot` starts this process, watches it and ends it.
"""

from __future__ import annotations

import ctypes
import faulthandler
import json
import os
import signal
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import replace
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
    guard = _guarded()  # noqa: F841
    rows: SimpleQueue[str] = SimpleQueue()
    threading.Thread(target=_read, args=(rows,), daemon=True).start()
    place = Place.of(json.loads(sys.argv[1]))
    place = replace(place, data=_data(place))
    try:
        _tell(answers, provenance(place))  # before anything of the study's own can fail
        if place.folder:
            sys.path.insert(0, place.folder)
        module, name = place.function.split(":")
        fly: Fly = getattr(import_module(module), name)
    except Exception:
        _tell(answers, {"unfit": _text(traceback.format_exc())})
        return
    _tell(answers, {"ready": True})
    while True:
        try:
            key, seed = json.loads(rows.get(timeout=IDLE_S))
        except Empty:  # a campaign that was killed on another machine may leave us here
            return
        if seed is None:
            _tell(answers, {"cannot": _rehearsed(getattr(sys.modules[module], "rehearse", None), key)})
        else:
            _tell(answers, _flown(fly, Trial(Case.from_key(key), seed), place))


def _guarded() -> object:
    """Somebody who ends what trials have started, once we are gone."""
    if sys.platform == "win32":
        return None
    command = [sys.executable, "-I", "-S", str(Path(__file__).with_name("guard.py")), str(os.getpid())]
    nothing = subprocess.DEVNULL
    return subprocess.Popen(command, stdin=nothing, stdout=nothing, stderr=nothing)


def _rehearsed(rehearse: Callable[[Any], None] | None, planners: Mapping[str, Any]) -> dict[str, str]:
    """Planners that cannot be made, and why."""
    found: dict[str, str] = {}
    if rehearse is None:  # a trial of the user's own, which alone knows what its planners mean
        return found
    for name, said in planners.items():
        try:
            rehearse(said)
        except Exception:
            found[name] = _text(traceback.format_exc())
    return found


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
        said: dict[str, Any] = {"answer": json.dumps(_plain(_object(fly(trial, place)), ""))}
    except MemoryError:
        said = {"ending": "memory", "reason": _text(traceback.format_exc())}
    except Exception:
        said = {"ending": "error", "reason": _text(traceback.format_exc())}
    return said | {
        "wall_s": time.perf_counter() - wall,
        "cpu_s": time.process_time() - cpu,
        "memory_mb": _peak_mb(),
    }


def _object(answer: Any) -> Mapping[str, Any]:
    if not isinstance(answer, Mapping):
        raise TypeError(f"the trial returned {type(answer).__name__}; expected an object, as {{'value': 1.5}}")
    return dict(answer)


def _plain(value: Any, key: str) -> Any:
    """What JSON can hold and whoever reads the ledger can use: arrays as lists; refuses what cannot be."""
    if value is None or isinstance(value, (bool, float)):
        return value
    if isinstance(value, int) and abs(value) <= sys.float_info.max:
        return value
    if isinstance(value, str) and value == _text(value):
        return value
    if isinstance(value, Mapping):
        for name in value:
            if not isinstance(name, str) or name != _text(name):
                raise TypeError(f"the answer{key} has the key {name!a}; expected text as keys")
        return {name: _plain(each, f"[{name!r}]" if not key else f"{key}[{name!r}]") for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each, f"{key}[{number}]") for number, each in enumerate(value)]
    if hasattr(value, "tolist"):
        return _plain(value.tolist(), key)
    if isinstance(value, int):
        raise ValueError(f"the answer{key} is a whole number above 1.8e308; expected one below")
    came = "text with half a character" if isinstance(value, str) else type(value).__name__
    raise TypeError(f"the answer{key} is {came}; expected numbers, text, lists or objects with text as keys")


def _text(said: str) -> str:
    """As UTF-8 can hold it."""
    return said.encode("utf-8", "replace").decode("utf-8")


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
