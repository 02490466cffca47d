"""How well agents hear one another in flight: range, loss and delay."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any

from sooner.errors import InvalidProblemError

__all__ = ["Links"]

MOST_DELAY_S = 100_000


@dataclass(frozen=True)
class Links:
    """Each second every agent sends one message to all others; who is near enough hears it, unless it is lost.

    Parameters
    ----------
    range_m : float      between two agents when a message is sent; 0: only at the same place, inf: anywhere
    loss : float         probability that one of them does not hear a message, each by itself
    delay_s : int        whole seconds from sending to hearing; 0: heard before that second's plans are made
    relays : bool        whether agents pass on what they have heard; False: only what they saw themselves

    Raises
    ------
    InvalidProblemError    for a negative range, a loss that is no probability, or a delay that is no whole number

    Examples
    --------
    >>> Links(range_m=50.0, loss=0.3).delay_s
    0
    """

    range_m: float = inf
    loss: float = 0.0
    delay_s: int = 0
    relays: bool = True

    def __post_init__(self) -> None:
        if not self.range_m >= 0.0:
            raise InvalidProblemError(f"links of range_m = {self.range_m} came; expected at least 0")
        if not 0.0 <= self.loss <= 1.0:
            raise InvalidProblemError(f"links of loss = {self.loss} came; expected a probability")
        if self.delay_s != int(self.delay_s) or not 0 <= self.delay_s <= MOST_DELAY_S:
            raise InvalidProblemError(f"links of delay_s = {self.delay_s} came; expected whole seconds, at least 0")

    def said(self) -> dict[str, Any]:
        """The same in words that JSON has, which knows no infinite range.

        >>> Links(delay_s=2).said()
        {'range_m': None, 'loss': 0.0, 'delay_s': 2, 'relays': True}
        """
        range_m = None if self.range_m == inf else self.range_m
        return {"range_m": range_m, "loss": self.loss, "delay_s": self.delay_s, "relays": self.relays}

    @classmethod
    def of(cls, said: dict[str, Any]) -> Links:
        """Links as `said` gives them."""
        return cls(**{**said, "range_m": inf if said["range_m"] is None else said["range_m"]})
