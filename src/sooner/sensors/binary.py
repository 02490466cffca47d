"""The binary sensor: a look at a cell answers yes or no, and may be wrong either way."""

from __future__ import annotations

from dataclasses import dataclass

from sooner.errors import InvalidProblemError

__all__ = ["BinarySensor"]


@dataclass(frozen=True)
class BinarySensor:
    """P(hit | a target is in the cell) and P(hit | none is); looks are independent given the cell.

    P(Z = 1 | X = 1) = p_d,  P(Z = 1 | X = 0) = p_f              [Kuhlman2017, section 6.3]

    Without false alarms (p_f = 0) it is the glimpse sensor: one hit settles the cell. The paper flies (0.85, 0.15).

    Parameters
    ----------
    detect : float           p_d, in (0, 1]
    false_alarm : float      p_f, in [0, p_d)

    Raises
    ------
    InvalidProblemError      if a probability lies outside [0, 1], or p_d does not exceed p_f

    Examples
    --------
    >>> BinarySensor(0.85, 0.15).symmetric, BinarySensor(0.6).false_alarm
    (True, 0.0)
    """

    detect: float
    false_alarm: float = 0.0

    def __post_init__(self) -> None:
        for name, value in (("detect", self.detect), ("false_alarm", self.false_alarm)):
            if not 0.0 <= value <= 1.0:
                raise InvalidProblemError(f"{name} = {value} came; expected a probability in [0, 1]")
        if self.detect <= self.false_alarm:
            raise InvalidProblemError(
                f"detect = {self.detect} and false_alarm = {self.false_alarm} came; expected detect to be the larger: "
                "a sensor that says yes no more often where a target is teaches nothing, or says yes for no"
            )

    @property
    def symmetric(self) -> bool:
        """Whether hits and misses weigh the same, p_d = 1 - p_f, so that only their difference counts."""
        return abs(self.detect + self.false_alarm - 1.0) < 1e-12
