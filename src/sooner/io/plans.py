"""Plans over cells as CSV: `searcher,step,row,col`, and bare `row,col` lines for one searcher."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sooner.errors import DataFormatError, Fault
from sooner.grid import Grid
from sooner.io.reading import bytes_of, lines_of
from sooner.problem import Plan

__all__ = ["is_whole", "plan_csv", "plan_lines", "raise_any", "read_plan"]

HEADER = ("searcher", "step", "row", "col")
MAX_BYTES = 1 << 30
_EXPECTED = "expected lines searcher,step,row,col, or row,col for one searcher"
_MOST_FAULTS = 10


def plan_csv(plan: Plan, grid: Grid) -> bytes:
    """A plan over cells as CSV.

    >>> print(plan_csv(Plan.of([0, 1, 3]), Grid((2, 2))).decode(), end="")
    searcher,step,row,col
    0,0,0,0
    0,1,0,1
    0,2,1,1
    """
    lines = [",".join(HEADER)]
    for searcher, cells in enumerate(plan.actions):
        rows, cols = np.divmod(cells, grid.shape[1])
        lines += [f"{searcher},{step},{row},{col}" for step, (row, col) in enumerate(zip(rows, cols, strict=True))]
    return ("\n".join(lines) + "\n").encode()


def read_plan(path: Path, grid: Grid) -> Plan:
    """Read a plan over the cells of `grid`; whether it may be flown, `evaluate` says.

    Raises
    ------
    DataFormatError       missing, unreadable, not whole numbers, steps out of order, cells off the map
    """
    rows = _whole_numbers(path)
    width = len(rows[0][1])
    if width == 2:
        rows = [(line, (0, step, *cell)) for step, (line, cell) in enumerate(rows)]
    flights: dict[int, list[int]] = {}
    faults = []
    for line, (searcher, step, row, col) in rows:
        if not (0 <= row < grid.shape[0] and 0 <= col < grid.shape[1]):
            map_is = f"rows 0 to {grid.shape[0] - 1} and columns 0 to {grid.shape[1] - 1}"
            faults.append(Fault(str(path), f"line {line}", f"cell [{row}, {col}] came", f"the map has {map_is}"))
            row, col = 0, 0
        flight = flights.setdefault(searcher, [])
        if step != len(flight):
            came = f"step {step} of searcher {searcher} came"
            faults.append(Fault(str(path), f"line {line}", came, f"expected step {len(flight)}"))
            break
        flight.append(row * grid.shape[1] + col)
    if sorted(flights) != list(range(len(flights))):
        came = f"searchers {', '.join(map(str, sorted(flights)))} came"
        faults.append(Fault(str(path), "searcher", came, "expected them numbered from 0 without a gap"))
    raise_any(faults)
    return Plan.of(*(flights[searcher] for searcher in range(len(flights))))


def _whole_numbers(path: Path) -> list[tuple[int, tuple[int, ...]]]:
    """(line number, values) of every line below the header."""
    lines = plan_lines(path, _EXPECTED)
    names = tuple(field.strip().lower() for field in lines[0][1].split(","))
    if names in (HEADER, HEADER[2:]):
        del lines[0]
    elif any(name and not is_whole(name) for name in names):
        raise DataFormatError(Fault(str(path), f"line {lines[0][0]}", f"{lines[0][1][:60]!r} came", _EXPECTED))
    if not lines:
        raise DataFormatError(Fault(str(path), "", "a plan without steps came", _EXPECTED))
    width = len(names)
    rows, faults = [], []
    for number, line in lines:
        fields = line.split(",")
        if len(fields) != width or width not in (2, 4) or not all(map(is_whole, fields)):
            expected = f"expected {width} whole numbers" if width in (2, 4) else _EXPECTED
            faults.append(Fault(str(path), f"line {number}", f"{line[:60]!r} came", expected))
            continue
        rows.append((number, tuple(int(field) for field in fields)))
    raise_any(faults)
    return rows


def plan_lines(path: Path, expected: str) -> list[tuple[int, str]]:
    """(number, text) of every line that is not blank."""
    return lines_of(path, bytes_of(path, MAX_BYTES, "1 GB", expected), expected)


def is_whole(field: str) -> bool:
    """Whether a field is a whole number that fits into 64 bits."""
    digits = field.strip().removeprefix("-")
    return digits.isascii() and digits.isdigit() and len(digits) <= 18


def raise_any(faults: list[Fault]) -> None:
    """Raise DataFormatError with the first of the faults, and how many more there are."""
    if len(faults) > _MOST_FAULTS:
        more = len(faults) - _MOST_FAULTS
        last = Fault(faults[0].file, "", f"{more} more lines are wrong", "see the lines above")
        faults = [*faults[:_MOST_FAULTS], last]
    if faults:
        raise DataFormatError(*faults)
