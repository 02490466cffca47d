"""Plans along legs as CSV: `searcher,place,east_m,north_m,time_s`, and latitude and longitude where they are known."""

from __future__ import annotations

from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault, InvalidProblemError
from sooner.grid import rows_and_cols
from sooner.io.georeference import Georeference
from sooner.io.plans import is_whole, plan_lines, raise_any
from sooner.problem import Plan, SearchProblem
from sooner.problem.leg_moves import LegMoves, place_numbers, places_of

__all__ = ["leg_plan_csv", "places_on_globe", "read_leg_plan"]

HEADER = ("searcher", "place", "east_m", "north_m", "time_s")
ON_GLOBE = ("lat", "lon")
LATE_S = 0.01  # by which a written time may differ: it has three decimals
MOST_PLACES = 1_000_000
_EXPECTED = f"expected lines {','.join(HEADER)}, with {','.join(ON_GLOBE)} after them or not; time_s may be left blank"


def leg_plan_csv(plan: Plan, problem: SearchProblem, ground: Georeference | None) -> bytes:
    """A plan along legs as CSV: metres from the centre of the south-west cell, and when the drone is there."""
    columns = HEADER if ground is None else HEADER + ON_GLOBE
    lines = [",".join(columns)]
    for number, (searcher, actions) in enumerate(zip(problem.searchers, plan.actions, strict=True)):
        moves = searcher.moves
        assert isinstance(moves, LegMoves)
        points, times = places_of(actions), moves.departs_s + moves.flight(actions).times
        globe = None if ground is None else places_on_globe(problem, ground, points)
        for place, ((east, north), time) in enumerate(zip(points.tolist(), times.tolist(), strict=True)):
            line = f"{number},{place},{east:.2f},{north:.2f},{time:.3f}"
            lines.append(line if globe is None else f"{line},{globe[place, 0]:.8f},{globe[place, 1]:.8f}")
    return ("\n".join(lines) + "\n").encode()


def places_on_globe(problem: SearchProblem, ground: Georeference, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 2) float: latitudes and longitudes of places in metres, (n, 2)."""
    return ground.places(rows_and_cols(problem.grid, points))


def read_leg_plan(path: Path, problem: SearchProblem) -> Plan:
    """Read a plan along legs; whether it may be flown, `evaluate` says. Metres count; latitudes are for people.

    Raises
    ------
    DataFormatError       missing, unreadable, places out of order, times at which the drone cannot be there
    """
    lines = plan_lines(path, _EXPECTED)
    names = tuple(name.strip().lower() for name in lines[0][1].split(","))
    if names not in (HEADER, HEADER + ON_GLOBE):
        raise DataFormatError(Fault(str(path), f"line {lines[0][0]}", f"{lines[0][1][:60]!r} came", _EXPECTED))
    if not 1 < len(lines) <= MOST_PLACES:
        raise DataFormatError(Fault(str(path), "", f"{len(lines) - 1} places came", _EXPECTED))
    flights: dict[int, list[tuple[float, float]]] = {}
    times: dict[int, list[tuple[int, str]]] = {}
    faults: list[Fault] = []
    for number, line in lines[1:]:
        fields = [field.strip() for field in line.split(",")]
        if len(fields) != len(names) or not all(map(is_whole, fields[:2])) or not all(map(_is_number, fields[2:4])):
            faults.append(Fault(str(path), f"line {number}", f"{line[:60]!r} came", _EXPECTED))
            continue
        searcher, place = int(fields[0]), int(fields[1])
        flight = flights.setdefault(searcher, [])
        if place != len(flight):
            came = f"place {place} of searcher {searcher} came"
            faults.append(Fault(str(path), f"line {number}", came, f"expected place {len(flight)}"))
            break
        flight.append((float(fields[2]), float(fields[3])))
        times.setdefault(searcher, []).append((number, fields[4]))
    raise_any(faults)
    if sorted(flights) != list(range(len(problem.searchers))):
        came = f"searchers {', '.join(map(str, sorted(flights)))} came"
        expected = f"expected 0 to {len(problem.searchers) - 1}, each sortie's places"
        raise DataFormatError(Fault(str(path), "searcher", came, expected))
    try:
        plan = Plan(tuple(place_numbers(flights[number]) for number in sorted(flights)))
    except InvalidProblemError as error:
        raise DataFormatError(Fault(str(path), "", str(error), _EXPECTED)) from None
    _check_times(path, problem, plan, times)
    return plan


def _check_times(path: Path, problem: SearchProblem, plan: Plan, said: dict[int, list[tuple[int, str]]]) -> None:
    """A plan that says it is somewhere sooner or later than it is was made for another drone or another day."""
    faults = []
    for number, actions in enumerate(plan.actions):
        moves = problem.searchers[number].moves
        assert isinstance(moves, LegMoves)
        if not any(text for _, text in said[number]) or not isfinite(moves.seconds(places_of(actions))):
            continue
        for (line, text), time in zip(said[number], moves.departs_s + moves.flight(actions).times, strict=True):
            if not text:
                continue
            if not _is_number(text) or abs(float(text) - time) > LATE_S:
                expected = f"expected {time:.3f} s, or nothing there"
                faults.append(Fault(str(path), f"line {line}", f"time {text[:20]!r} came", expected))
                break
    raise_any(faults)


def _is_number(text: str) -> bool:
    try:
        return isfinite(float(text))
    except ValueError:
        return False
