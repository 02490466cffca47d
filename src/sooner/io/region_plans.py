"""Plans over regions as CSV: `searcher,action,kind,region,row,col,time_s`, a line for each thing that is flown."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault
from sooner.grid import rows_and_cols
from sooner.io.plans import is_whole, plan_lines, raise_any
from sooner.problem import Plan, Searcher, SearchProblem
from sooner.problem.regions import RegionGraph, RegionMoves

__all__ = ["Stage", "read_region_plan", "region_plan_csv", "stages"]

HEADER = ("searcher", "action", "kind", "region", "row", "col", "time_s")
ACTIONS = ("search", "traverse")
KINDS = ("start", "depart", *ACTIONS, "return")
LATE_S = 0.01  # by which a written time may differ: it has three decimals
_EXPECTED = f"expected lines {','.join(HEADER)}; row, col and time_s may be left blank"


@dataclass(frozen=True)
class Stage:
    """A line of a plan: what is flown, and where and when it ends.

    Parameters
    ----------
    kind : str              "start" (nothing is flown yet), "depart" (from the start to the first region's centre),
                            "search", "traverse" (to the next region), "return" (to where the searcher must end)
    region : int            in which it ends
    cell : (row, col)       where it ends; over regions, at the region's centre
    time_s : float          when it ends
    """

    kind: str
    region: int
    cell: tuple[int, int]
    time_s: float


def stages(problem: SearchProblem, searcher: Searcher, actions: NDArray[np.int64]) -> Iterator[Stage]:
    """The lines of one searcher's plan."""
    moves = searcher.moves
    assert isinstance(moves, RegionMoves)
    graph, here = moves.graph, moves.first
    yield Stage("start", here, searcher.start, 0.0)
    for action, begun, turned in moves.flown(actions):
        over = begun + float(graph.seconds[action])
        if action < graph.n_regions:
            kind = "search"
        elif action < graph.n_regions + graph.n_edges:
            kind, here = "traverse", int(graph.edges[action - graph.n_regions, 0 if turned else 1])
        else:
            kind = "depart" if action == moves.depart else "return"
        end = searcher.end if kind == "return" and searcher.end else _centre(problem, graph, here)
        yield Stage(kind, here, end, over)


def _centre(problem: SearchProblem, graph: RegionGraph, region: int) -> tuple[int, int]:
    row, col = np.rint(rows_and_cols(problem.grid, graph.paths[region][:1]))[0]
    return int(row), int(col)


def region_plan_csv(plan: Plan, problem: SearchProblem) -> bytes:
    """A plan over regions as CSV."""
    lines = [",".join(HEADER)]
    for number, (searcher, actions) in enumerate(zip(problem.searchers, plan.actions, strict=True)):
        for step, stage in enumerate(stages(problem, searcher, actions)):
            row, col = stage.cell
            lines.append(f"{number},{step},{stage.kind},{stage.region},{row},{col},{stage.time_s:.3f}")
    return ("\n".join(lines) + "\n").encode()


def read_region_plan(path: Path, problem: SearchProblem) -> Plan:
    """Read a plan over regions; whether it may be flown, `evaluate` says.

    Lines of kind start, depart and return are no actions, and may be left out. What a line says of place and time
    must be so: a plan made for other regions, or one that takes longer to fly than it says, is refused.

    Raises
    ------
    DataFormatError       missing, unreadable, unknown kinds, actions out of order, other places or times
    """
    flights: dict[int, list[_Line]] = {}
    faults: list[Fault] = []
    for line in _lines(path):
        flight = flights.setdefault(line.searcher, [])
        if line.step != len(flight):
            came = f"action {line.step} of searcher {line.searcher} came"
            faults.append(Fault(str(path), f"line {line.number}", came, f"expected action {len(flight)}"))
            break
        flight.append(line)
    if sorted(flights) != list(range(len(flights))):
        came = f"searchers {', '.join(map(str, sorted(flights)))} came"
        faults.append(Fault(str(path), "searcher", came, "expected them numbered from 0 without a gap"))
    raise_any(faults)
    if len(flights) != len(problem.searchers):
        came = f"a plan for {len(flights)} searcher{'s' * (len(flights) != 1)} came"
        raise DataFormatError(Fault(str(path), "searcher", came, f"expected {len(problem.searchers)}"))
    plan = Plan.of(*(_actions(path, problem.searchers[number], flights[number]) for number in range(len(flights))))
    for number, actions in enumerate(plan.actions):
        _check_stages(path, problem, number, actions, flights[number])
    return plan


@dataclass(frozen=True)
class _Line:
    """A line of a file: its number, and what it says."""

    number: int
    searcher: int
    step: int
    kind: str
    region: int
    place: tuple[str, str]
    time_s: str


def _lines(path: Path) -> list[_Line]:
    """Every line below the header."""
    lines = plan_lines(path, _EXPECTED)
    number, first = lines[0]
    if tuple(name.strip().lower() for name in first.split(",")) != HEADER:
        raise DataFormatError(Fault(str(path), f"line {number}", f"{first[:60]!r} came", _EXPECTED))
    if len(lines) == 1:
        raise DataFormatError(Fault(str(path), "", "a plan without actions came", _EXPECTED))
    read, faults = [], []
    for number, line in lines[1:]:
        fields = [field.strip() for field in line.split(",")]
        wrong = len(fields) != len(HEADER) or not all(map(is_whole, (*fields[:2], fields[3])))
        wrong = wrong or not all(map(is_whole, filter(None, fields[4:6]))) or not _is_seconds(fields[6])
        if wrong or fields[2] not in KINDS:
            told = f"expected whole numbers, one of {', '.join(KINDS)}, and seconds"
            faults.append(Fault(str(path), f"line {number}", f"{line[:60]!r} came", told))
            continue
        searcher, step, kind, region, row, col, time_s = fields
        read.append(_Line(number, int(searcher), int(step), kind, int(region), (row, col), time_s))
    raise_any(faults)
    return read


def _actions(path: Path, searcher: Searcher, lines: list[_Line]) -> list[int]:
    """The numbers of the actions, each of which begins where the one before ended."""
    moves, actions = searcher.moves, []
    assert isinstance(moves, RegionMoves)
    here = moves.first
    for line in lines:
        if line.kind not in ACTIONS:
            continue
        ways = ((here, here),) if line.kind == "search" else moves.graph.ways[here]
        action = next((action for action, there in ways if there == line.region), None)
        if action is None:
            near = ", ".join(str(there) for _, there in moves.graph.ways[here]) or "none"
            came = f"{line.kind} {line.region} came in region {here}"
            expected = f"expected search {here}, or traverse to one of: {near}"
            raise DataFormatError(Fault(str(path), f"line {line.number}", came, expected))
        actions.append(action)
        here = line.region
    return actions


def _check_stages(
    path: Path, problem: SearchProblem, number: int, actions: NDArray[np.int64], lines: list[_Line]
) -> None:
    """What lines say of places and times is so."""
    flown = [*stages(problem, problem.searchers[number], actions)]
    waiting = {kind: iter([stage for stage in flown if stage.kind == kind]) for kind in KINDS}
    faults = []
    for line in lines:
        stage = next(waiting[line.kind], None)
        where, came = f"line {line.number}", f"{line.kind} ends in region {line.region} at [{', '.join(line.place)}]"
        if stage is None:
            faults.append(Fault(str(path), where, f"{line.kind} came", f"this mission flies no such leg for {number}"))
            continue
        told = str(stage.cell[0]), str(stage.cell[1])
        if line.region != stage.region or any(
            said not in ("", true) for said, true in zip(line.place, told, strict=True)
        ):
            expected = f"expected region {stage.region} at [{', '.join(told)}], as this mission cuts its ground"
            faults.append(Fault(str(path), where, came, expected))
        elif line.time_s and abs(float(line.time_s) - stage.time_s) > LATE_S:
            expected = f"expected {stage.time_s:.3f} s, when a drone that flies as this mission says is there"
            faults.append(Fault(str(path), where, f"{line.kind} ends at {line.time_s} s", expected))
    raise_any(faults)


def _is_seconds(text: str) -> bool:
    try:
        return not text or bool(np.isfinite(float(text)))
    except ValueError:
        return False
