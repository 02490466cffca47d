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

import re
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
    "printable",
]

# C0 and C1, ends of lines, and marks that turn the direction of writing
_CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069]")


def printable(text: str, but: str = "") -> str:
    """A text of others, as it may reach a terminal: control characters as they would be written in Python.

    >>> print(printable("red \\x1b[31m"))
    red \\x1b[31m
    """
    return _CONTROL.sub(lambda found: found[0] if found[0] in but else found[0].encode("unicode_escape").decode(), text)


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
        return printable(f"{where}: {self.came}; {self.expected}", but="\n")


class DataFormatError(SoonerError, ValueError):
    """A file that cannot be used; `faults` lists every reason found."""

    def __init__(self, *faults: Fault) -> None:
        self.faults = faults
        super().__init__("\n".join(str(fault) for fault in faults))
