"""How long a vehicle is waited for."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Patience"]


@dataclass(frozen=True)
class Patience:
    """Seconds and tries, all of them bounded, so that a vehicle that falls silent ends the upload.

    Parameters
    ----------
    heartbeat_s : float     for the first heartbeat
    neighbours_s : float    to hear whether there are other vehicles; heartbeats come once a second
    answer_s : float        for an answer, before the question is asked again
    silence_s : float       for the next request while items are sent; vehicles ask again by themselves before that
    tries : int             of a question, and of a transfer that broke off
    busy_s : float          between tries where the vehicle has no space yet, as ArduPilot just after it was switched on
    busy_tries : int
    warnings_s : float      at the end, for what the autopilot has to say of its new mission
    """

    heartbeat_s: float = 20.0
    neighbours_s: float = 1.5
    answer_s: float = 1.5
    silence_s: float = 5.0
    tries: int = 5
    busy_s: float = 2.0
    busy_tries: int = 10
    warnings_s: float = 0.5
