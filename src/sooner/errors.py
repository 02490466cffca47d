"""The error tree; every room may import it.

::

    SoonerError
    ├── InvalidProblemError (ValueError)         a problem that cannot be posed: NaN weights, start on an obstacle
    │   └── InfeasibleProblemError               well posed, but no legal plan exists: end cell too far, wrong parity
    ├── IllegalPlanError (ValueError)            a plan that breaks the problem's rules; says which step and why
    ├── UnsupportedProblemError (ValueError)     a planner or bound that does not handle this kind of problem
    ├── ImpossibleObservationError (ValueError)  an observation with probability zero under the belief
    └── DataFormatError (ValueError)             files: every fault with file, key, what came, what was expected
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "DataFormatError",
    "Fault",
    "IllegalPlanError",
    "ImpossibleObservationError",
    "InfeasibleProblemError",
    "InvalidProblemError",
    "SoonerError",
    "UnsupportedProblemError",
]


class SoonerError(Exception):
    """Root of everything that sooner raises on purpose."""


class InvalidProblemError(SoonerError, ValueError):
    """The problem cannot be posed as given."""


class InfeasibleProblemError(InvalidProblemError):
    """The problem is well posed, but no legal plan exists."""


class IllegalPlanError(SoonerError, ValueError):
    """The plan breaks a rule of the problem."""


class UnsupportedProblemError(SoonerError, ValueError):
    """The planner or bound does not handle this kind of problem."""


class ImpossibleObservationError(SoonerError, ValueError):
    """What was observed had probability zero."""


@dataclass(frozen=True)
class Fault:
    """One fault of a file: where, what came, what was expected.

    >>> print(Fault("mission.toml", "budget.steps", "came -3", "expected a whole number of at least 1"))
    mission.toml: budget.steps: came -3; expected a whole number of at least 1
    """

    file: str
    key: str
    came: str
    expected: str

    def __str__(self) -> str:
        where = f"{self.file}: {self.key}" if self.key else self.file
        return f"{where}: {self.came}; {self.expected}"


class DataFormatError(SoonerError, ValueError):
    """A file that cannot be used; `faults` lists every reason found."""

    def __init__(self, *faults: Fault) -> None:
        self.faults = faults
        super().__init__("\n".join(str(fault) for fault in faults))
