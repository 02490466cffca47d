"""Rounds of annealing: when one begins, how far it is, when the next begins."""

from __future__ import annotations

__all__ = ["FIRST_ROUND", "Rounds"]

FIRST_ROUND = 64  # ticks of the first round where the stop rule has no horizon
PACED = 8, 40  # between these ticks a round sees what part of the run a tick takes; starts are made before


class Rounds:
    """When a round of annealing begins and ends: in equal parts of the run, none much longer than `longest` ticks;
    where nobody knows how long the run is, twice as long each time.
    """

    def __init__(self, longest: int, ticks: int = FIRST_ROUND, begin: float | None = None) -> None:
        self.longest, self.ticks, self.begin = longest, ticks, begin
        self.tick, self.width, self.mark = 0, 0.0, 0.0

    def begun(self, share: float | None) -> Rounds:
        """The next round, at this share of the run."""
        known = share is not None and share < 1.0
        return Rounds(self.longest, self.ticks if known or not self.tick else 2 * self.ticks, share if known else None)

    def now(self, share: float | None) -> float:
        """How much of the round is over, in [0, 1]."""
        if self.begin is None or share is None:
            return self.tick / self.ticks
        if self.tick == PACED[0]:
            self.mark = share
        elif self.tick == PACED[1] and share > self.mark:  # by now we know what part of the run one tick takes
            parts = (1.0 - self.begin) * (PACED[1] - PACED[0]) / (share - self.mark) / self.longest
            self.width = (1.0 - self.begin) / max(round(parts), 1)
        return (share - self.begin) / (self.width or 1.0 - self.begin)
