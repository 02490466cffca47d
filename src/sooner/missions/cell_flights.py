"""A searcher's flight over cells or regions on the globe: the line that the judge times, and how it goes home."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault
from sooner.grid.paths import centres_of, line_is_clear, rows_and_cols, way
from sooner.io.flights import Fence, FlightPlan, Waypoint
from sooner.io.flights.flight_plan import Finish, Place
from sooner.io.georeference import Georeference
from sooner.missions.drawn_fences import drawn_fences
from sooner.missions.fences import fences
from sooner.missions.mission_file import Mission
from sooner.missions.over_regions import dynamics_of
from sooner.missions.score import Score
from sooner.missions.settings import Place as OnGlobe
from sooner.motion.kinematics import Dynamics, corners
from sooner.problem.regions import RegionMoves

__all__ = ["USUAL_M", "cell_flight"]

USUAL_M = 60.0  # above home, where neither the drone nor the camera has an altitude
USUAL_MPS2 = 2.0  # by which copters speed up and brake, where nobody says
SAME_M = 1e-6  # between places that are one but for rounding

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Line:
    """What a searcher flies.

    Parameters
    ----------
    cells : (n, 2) float        rows and columns, as fractions, where the line turns or is held
    hold_s : (n,) float         seconds to stay there
    speed_mps : float or None
    duration_s : float or None
    notes : tuple of str
    """

    cells: Floats
    hold_s: Floats
    speed_mps: float | None
    duration_s: float | None
    notes: tuple[str, ...] = ()


def cell_flight(score: Score, number: int, ground: Georeference) -> tuple[FlightPlan, tuple[str, ...]]:
    """The flight of one searcher over cells or regions, and what whoever flies it should know."""
    mission, problem = score.mission, score.mission.problem
    said = mission.settings.searcher[number]
    line = _over_regions(score, number) if mission.over_regions else _over_cells(score, number)
    finish, home_cells, way_notes = _homeward(mission, number, line)
    cells = np.concatenate([line.cells, home_cells])
    hold_s = np.concatenate([line.hold_s, np.zeros(len(home_cells))])
    altitude_m, altitude_notes = _altitude(mission, number)
    places = [(float(lat), float(lon)) for lat, lon in ground.places(cells)]
    home = _told(said.start, places[0])
    if finish != "return":
        places[-1] = _told(said.end, places[-1])
    fenced, fence_notes = _fences(mission, ground, ground.cells([home, *places]), finish == "return")
    placed = zip(places, hold_s.tolist(), strict=True)
    plan = FlightPlan(
        name=mission.name if len(problem.searchers) == 1 else f"{mission.name}, drone {number}",
        searcher=number,
        home=home,
        waypoints=tuple(Waypoint(lat, lon, altitude_m, hold_s=hold) for (lat, lon), hold in placed),
        finish=finish,
        speed_mps=line.speed_mps,
        duration_s=line.duration_s,
        fences=fenced,
        landings=() if finish == "return" else (places[-1],),
        kind=said.kind,
    )
    return plan, (*line.notes, *way_notes, *fence_notes, *altitude_notes)


def _fences(
    mission: Mission, ground: Georeference, cells: Floats, closed: bool
) -> tuple[tuple[Fence, ...], tuple[str, ...]]:
    """Around what is drawn, where it is; else around the obstacles of a raster."""
    grid = mission.problem.grid
    if mission.area is None:
        return fences(grid, ground, cells, closed)
    return drawn_fences(mission, np.column_stack([cells[:, 1], grid.shape[0] - 1 - cells[:, 0]]) * grid.cell_m, closed)


def _told(said: object, centre: Place) -> Place:
    """A place as the mission tells it: by coordinates, or as the centre of a cell."""
    return (said.lat, said.lon) if isinstance(said, OnGlobe) else centre


def _altitude(mission: Mission, number: int) -> tuple[float, tuple[str, ...]]:
    """Metres above home: what the drone is told, else what the camera needs."""
    said, camera = mission.settings.searcher[number].altitude_m, mission.settings.sensor.camera
    seen = None if camera is None else camera.altitude_m
    if said is not None and seen is not None and said != seen:
        return said, (f"flown {said:g} m high, and what the camera sees is worked out for {seen:g} m",)
    found = said if said is not None else seen
    return (USUAL_M, (f"nobody says how high: flown {USUAL_M:g} m above home",)) if found is None else (found, ())


# ---------------------------------------------------------------- the line over cells


def _over_cells(score: Score, number: int) -> _Line:
    """Centres of cells, hovering as a hold."""
    mission, actions = score.mission, score.plan.actions[number]
    moved = np.flatnonzero(np.append(True, actions[1:] != actions[:-1]))
    waited = np.diff(np.append(moved, len(actions))) - 1
    if waited.any() and mission.step_s is None:
        key, came = f"searcher[{number}].speed_mps", "nothing came, and the plan hovers"
        raise DataFormatError(
            Fault(str(mission.path), key, came, "expected metres a second: who hovers must know how long")
        )
    cells = np.column_stack(np.divmod(actions[moved], mission.problem.grid.shape[1])).astype(np.float64)
    hold_s = waited * (mission.step_s or 0.0)
    seconds = None if score.durations is None else score.durations[number]
    line = _straightened(_Line(cells, hold_s, mission.settings.searcher[number].speed_mps, seconds))
    return replace(line, notes=_uncounted(mission, line))


def _uncounted(mission: Mission, line: _Line) -> tuple[str, ...]:
    """What corners cost, which the time of a plan over cells does not count."""
    turns = len(line.cells) - 2
    if turns < 1 or line.speed_mps is None or line.duration_s is None:
        return ()
    stopping = _stopping_s(mission, line, Dynamics(line.speed_mps, USUAL_MPS2))
    if stopping <= line.duration_s:
        return ()
    told = f"the plan's {line.duration_s:.0f} s count no time for corners, of which it has {turns}"
    return (f"{told}; an aircraft that stops in each, at {USUAL_MPS2:g} m/s2, takes {stopping:.0f} s",)


def _stopping_s(mission: Mission, line: _Line, drone: Dynamics) -> float:
    """Seconds along the line for who stops wherever it turns."""
    lengths = np.hypot(*np.diff(line.cells, axis=0).T) * mission.problem.grid.cell_m
    return float(drone.leg_seconds(lengths).sum() + line.hold_s.sum())


# ---------------------------------------------------------------- the line over regions


def _over_regions(score: Score, number: int) -> _Line:
    """The waypoints of searches, ways and legs; a search without a move is a hold."""
    problem, actions = score.mission.problem, score.plan.actions[number]
    moves = problem.searchers[number].moves
    assert isinstance(moves, RegionMoves)
    points, held = [np.zeros((0, 2))], []
    for action, _, turned in moves.flown(actions):
        path = moves.graph.paths[action]
        still = len(path) == 1 or not np.ptp(path, axis=0).any()
        points.append(path[:1] if still else path[::-1] if turned else path)
        held += [*[0.0] * (len(points[-1]) - 1), float(moves.graph.seconds[action]) if still else 0.0]
    return _timed(score.mission, number, np.concatenate(points), np.array(held), moves.seconds(actions))


def _timed(mission: Mission, number: int, points: Floats, held: Floats, seconds: float) -> _Line:
    """The same line without what it says twice, and how long the aircraft takes that stops wherever it turns."""
    begins = np.flatnonzero(np.append(True, np.hypot(*np.diff(points, axis=0).T) > SAME_M))
    cells = rows_and_cols(mission.problem.grid, points[begins])
    drone = dynamics_of(mission.settings, number)
    line = _straightened(_Line(cells, np.add.reduceat(held, begins), drone.v_max, None))
    stopping = _stopping_s(mission, line, drone)
    late = stopping - seconds
    notes = (f"the plan flies arcs; an aircraft that stops in corners takes {late:.0f} s more",) if late > 1.0 else ()
    return replace(line, duration_s=stopping, notes=notes)


# ---------------------------------------------------------------- both


def _straightened(line: _Line) -> _Line:
    """The same line by its ends, its turns and the places where it is held."""
    kept = np.union1d(corners(line.cells), np.flatnonzero(line.hold_s))
    return replace(line, cells=line.cells[kept], hold_s=line.hold_s[kept])


def _homeward(mission: Mission, number: int, line: _Line) -> tuple[Finish, Floats, tuple[str, ...]]:
    """How a flight ends, the places on the way home that go round obstacles, and what the plan does not count."""
    none, searcher = np.zeros((0, 2)), mission.problem.searchers[number]
    if searcher.end is not None and searcher.end != searcher.start:
        return "loiter" if mission.settings.searcher[number].kind == "fixed_wing" else "land", none, ()
    if searcher.end is not None:
        return "return", none, ()
    grid = mission.problem.grid
    last, first = (int(row) * grid.shape[1] + int(col) for row, col in np.rint(line.cells[[-1, 0]]).astype(int))
    if last == first:
        return "return", none, ()
    ends = centres_of(grid, [last, first])
    home = ends if line_is_clear(grid, *ends) else way(grid, last, first, taut=True)
    metres = float(np.hypot(*np.diff(home, axis=0).T).sum())
    seconds = "" if not line.speed_mps else f", about {metres / line.speed_mps:.0f} s,"
    note = f"the mission has no end, so the plan does not count the {metres:.0f} m{seconds} home"
    return "return", rows_and_cols(grid, home[1:-1]) if len(home) > 2 else none, (note,)
