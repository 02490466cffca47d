"""What runs in the workers of Dask: a seat for each of their threads, with a `Slot` in it.

A trial that nobody waits for any more (the campaign was interrupted, or killed, or its scheduler is gone) would keep
its seat until it ends, or for ever where it hangs. So every second somebody looks: such a trial is ended, and so are
processes that have had nothing to do for a while.

`Cluster` sends trials here, and answers go back, as text: where sooner is not installed, objects of its classes would
end the worker or the scheduler that Dask hands them to.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from sooner.campaigns.slot import Slot
from sooner.campaigns.trial import Case, Limits, Outcome, Place, Trial

__all__ = ["asked", "carrier", "flown", "land", "told"]

LOOK_S = 1.0
IDLE_S = 60.0  # with no trial; the next one pays for a new start


@dataclass
class _Seat:
    """A slot, and which task of which worker it works for."""

    slot: Slot
    worker: Any
    task: str = ""  # key of the task; "" while idle
    since: float = field(default_factory=time.monotonic)  # the last trial went or came
    left: bool = False  # its process was ended by us

    def unwanted(self) -> bool:
        """Nobody waits for its trial, or it has had none for long."""
        if self.worker.status.name in ("closing", "closed", "failed"):
            return True
        if not self.task:
            return time.monotonic() - self.since > IDLE_S
        task = self.worker.state.tasks.get(self.task)
        return task is None or task.state == "cancelled"

    def leave(self) -> None:
        """End its process; a trial in it comes back as lost."""
        self.left = True
        self.slot.close()


_seats: dict[tuple[str, int], _Seat] = {}  # by campaign and thread
_landed: set[str] = set()
_door = threading.Lock()  # of the two above


def carrier(name: str) -> Callable[[str], str]:
    """A function of this module for Dask to carry: by value, so that a worker without sooner can say that it has none.

    Dask carries what a module defines by its name, and loses the worker where there is no such module.
    """

    def called(text: str) -> str:
        from importlib import import_module
        from platform import node

        try:
            said: str = getattr(import_module("sooner.campaigns.seats"), name)(text)
        except (ImportError, OSError) as error:  # this machine is not fit for us; say which it is
            raise type(error)(f"{error}, on {node()}") from None
        return said

    return called


def asked(campaign: str, trial: Trial, place: Place, limits: Limits) -> str:
    """What `flown` takes."""
    return json.dumps([campaign, trial.case.key, trial.seed, asdict(place), asdict(limits)])


def told(trial: Trial, text: str) -> Outcome:
    """What `flown` answered."""
    return Outcome(trial, **json.loads(text))


def flown(text: str) -> str:
    """Fly in this thread's seat."""
    campaign, key, seed, place, limits = json.loads(text)
    outcome = _flown(campaign, Trial(Case.from_key(key), seed), Place.of(place), Limits(**limits))
    return json.dumps({name: value for name, value in vars(outcome).items() if name != "trial"})


def _flown(campaign: str, trial: Trial, place: Place, limits: Limits) -> Outcome:
    seat = _seated(campaign, place, limits)
    if seat is None:
        return Outcome(trial, "lost", reason="the campaign is over")
    try:
        outcome = seat.slot.run(trial)
    finally:
        with _door:
            seat.task, seat.since = "", time.monotonic()
    if seat.left:
        return Outcome(trial, "lost", reason="its worker was closed, or nobody waited for it")
    if outcome.ending in ("crash", "error") and not Path(place.folder).is_dir():
        raise FileNotFoundError(f"the folder of the study, {place.folder}, is not there")
    return outcome


def land(campaign: str) -> str:
    """The campaign is over: end its processes, and begin none for trials that are still on their way."""
    with _door:
        _landed.add(campaign)
        for key in [key for key in _seats if key[0] == campaign]:
            _seats.pop(key).leave()
    return campaign


def _seated(campaign: str, place: Place, limits: Limits) -> _Seat | None:
    """The seat of this thread, taken; None where its campaign is over."""
    from distributed import get_worker

    worker = get_worker()
    mine = campaign, threading.get_ident()
    with _door:
        if campaign in _landed:
            return None
        if not _seats:
            threading.Thread(target=_look_after, name="sooner-seats", daemon=True).start()
        if mine not in _seats:
            memory_mb = min(limits.memory_mb, _share_mb(worker))
            _seats[mine] = _Seat(Slot(place, replace(limits, memory_mb=memory_mb)), worker)
        seat = _seats[mine]
        seat.task, seat.since = str(worker.get_current_task()), time.monotonic()
        return seat


def _look_after() -> None:
    """Clear seats that are not wanted, until there are none."""
    while True:
        time.sleep(LOOK_S)
        with _door:
            for key in [key for key, seat in _seats.items() if seat.unwanted()]:
                _seats.pop(key).leave()
            if not _seats:
                return


def _share_mb(worker: Any) -> float:
    """What one thread of a worker may have of the memory that Dask gives to the worker."""
    limit = worker.memory_manager.memory_limit
    return float(limit) / 2**20 / worker.state.nthreads if limit else math.inf
