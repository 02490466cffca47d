"""From a plan to flights on the globe: the line that the judge times, as places that an aircraft is told."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault, InvalidProblemError
from sooner.grid.paths import centres_of, line_is_clear, rows_and_cols, way
from sooner.io.flights import Fence, FlightPlan, Waypoint
from sooner.io.flights.flight_plan import Finish, Place
from sooner.io.georeference import Georeference
from sooner.missions.drawn_fences import drawn_fences
from sooner.missions.fences import fences
from sooner.missions.leg_flights import label, leg_flight
from sooner.missions.leg_tracks import leg_track
from sooner.missions.mission_file import Mission
from sooner.missions.over_regions import dynamics_of
from sooner.missions.score import Score
from sooner.missions.separation import STEP_S, Apart, Separation, separated
from sooner.missions.separations import SeparationSettings
from sooner.missions.settings import Place as OnGlobe
from sooner.motion.kinematics import Dynamics, corners
from sooner.problem.regions import RegionMoves

__all__ = ["USUAL_M", "Flights", "check_place", "flights"]

USUAL_M = 60.0  # above home, where neither the drone nor the camera has an altitude
USUAL_MPS2 = 2.0  # by which copters speed up and brake, where nobody says
SAME_M = 1e-6  # between places that are one but for rounding
TRUE_TO = 0.01  # share by which a metre of the projection may differ from one on the ground, untold

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Flights:
    """A plan as aircraft fly it.

    Parameters
    ----------
    plans : of FlightPlan       one for each searcher
    own : of tuple of str       what whoever flies each of them should know
    shared : of str             what concerns all of them
    separation : Separation or None     how they are kept apart; None for one drone, and but along legs
    """

    plans: tuple[FlightPlan, ...]
    own: tuple[tuple[str, ...], ...]
    shared: tuple[str, ...] = ()
    separation: Separation | None = None

    @property
    def notes(self) -> tuple[str, ...]:
        """All that there is to know."""
        return (*(note for notes in self.own for note in notes), *self.shared)

    def about(self, plan: FlightPlan) -> tuple[str, ...]:
        """What concerns one of the flights, or all of them."""
        return (*self.own[self.plans.index(plan)], *self.shared)


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


def check_place(mission: Mission) -> Georeference:
    """Where the mission's cells lie on the globe.

    Raises
    ------
    DataFormatError         if nobody says
    """
    area = mission.settings.area
    key = "area.evidence" if area.poc is None else "area.poc"
    if mission.settings.area.grid == "hex":
        came = "'hex' came, whose cells do not lie on those of a raster"
        raise DataFormatError(Fault(str(mission.path), "area.grid", came, "expected square cells for files that fly"))
    if mission.ground is None:
        expected = "expected a GeoTIFF with its place on the globe: files that fly need latitudes and longitudes"
        raise DataFormatError(Fault(str(mission.path), key, "a raster without a georeference came", expected))
    return mission.ground


def flights(score: Score) -> Flights:
    """A judged plan as flights: straight lines through the same places in the same order.

    Over cells the line goes through their centres, over regions along the waypoints that are timed, along legs from
    place to place, at one height above the ground where that is known; where it goes on straight there is no other
    waypoint, where the plan waits the aircraft holds. A drone whose mission has an end away from
    its start lands there; every other flies home at last, around obstacles where the straight way is not free.

    Several drones along legs keep apart: where two would come too near to each other, one takes off later.

    Raises
    ------
    DataFormatError         if the mission does not say where on the globe it lies, or a speed that the plan needs; or
                            if drones would have to wait for each other longer than they may
    """
    mission, ground = score.mission, check_place(score.mission)
    plans, own = [], []
    for number in range(len(score.plan.actions)):
        drone = mission.sorties[number].drone if mission.over_legs else number
        try:
            plan, notes = (leg_flight if mission.over_legs else _flight)(score, number, ground)
        except InvalidProblemError as error:
            came, _, expected = str(error).partition("; ")
            raise DataFormatError(Fault(str(mission.path), f"searcher[{drone}]", came, expected)) from None
        name = label(mission, number) if mission.over_legs else f"drone {number}"
        plans.append(plan)
        own.append(tuple(f"{name}: {note}" for note in notes))
    if not mission.over_legs:
        return Flights(tuple(plans), tuple(own), (*_scale(mission, ground), *_levels(tuple(plans))))
    return _kept_apart(score, Flights(tuple(plans), tuple(own), (*_scale(mission, ground), *_ground(mission))))


def _kept_apart(score: Score, told: Flights) -> Flights:
    """The same flights with take-offs put off where they must be, and how near they then come."""
    mission = score.mission
    if len({sortie.drone for sortie in mission.sorties}) == 1:
        return told
    said = mission.settings.separation or SeparationSettings()
    tracks = [leg_track(score, number, plan) for number, plan in enumerate(told.plans)]
    found = separated(tracks, Apart(said.horizontal_m, said.vertical_m, said.wait_s), str(mission.path))
    plans = tuple(
        replace(plan, departs_s=plan.departs_s + delay) for plan, delay in zip(told.plans, found.delays_s, strict=True)
    )
    kept = f"to keep {said.horizontal_m:g} m on the map or {said.vertical_m:g} m in height from others"
    own = tuple(
        (*notes, f"{track.name}: takes off {delay:.0f} s later than planned, {kept}") if delay else notes
        for track, notes, delay in zip(tracks, told.own, found.delays_s, strict=True)
    )
    return Flights(plans, own, (*told.shared, *_near(mission, found, [track.name for track in tracks])), found)


def _near(mission: Mission, found: Separation, names: list[str]) -> tuple[str, ...]:
    """How near flights come to each other, and how much longer all takes."""
    nearest = min(found.meetings, key=lambda each: each.share, default=None)
    if nearest is None:
        return ("no two drones are in the air at once",)
    a, b = (names[number] for number in nearest.flights)
    near = f"{nearest.horizontal_m:.0f} m on the map with {nearest.vertical_m:.0f} m in height"
    told = [f"{a} and {b} come nearest to each other of all, after {nearest.time_s:.0f} s: {near} between them"]
    longer, whole = found.ends_s - found.planned_s, mission.settings.budget.seconds
    if longer > 0:
        past = f", past budget.seconds = {whole:g}" if whole is not None and found.ends_s > whole + STEP_S else ""
        told.append(
            f"as take-offs wait, the last lands {longer:.0f} s later than planned, after {found.ends_s:.0f} s{past}"
        )
    return tuple(told)


# ---------------------------------------------------------------- one flight


def _flight(score: Score, number: int, ground: Georeference) -> tuple[FlightPlan, tuple[str, ...]]:
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


def _levels(plans: tuple[FlightPlan, ...]) -> tuple[str, ...]:
    heights = [plan.waypoints[0].altitude_m for plan in plans]
    if len(set(heights)) == len(heights):
        return ()
    return (f"{len(plans)} drones, some at the same height: give each its own searcher.altitude_m, or fly in turn",)


def _ground(mission: Mission) -> tuple[str, ...]:
    if mission.area is not None and mission.area.elevation is not None:
        return ()
    return ("nobody says how high the ground is (area.elevation): heights are those above home all the way",)


def _scale(mission: Mission, ground: Georeference) -> tuple[str, ...]:
    """A projection whose metres are not those of the ground tells times that are not those of the flight."""
    height, width = mission.problem.grid.shape
    scale = ground.scale_at((height - 1) / 2, (width - 1) / 2)
    if abs(scale - 1.0) <= TRUE_TO:
        return ()
    return (
        f"a metre of {ground.crs} is {scale:.3g} m on the ground here, so times of the plan are not those of the "
        "flight: reproject the rasters, to UTM for one",
    )


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
