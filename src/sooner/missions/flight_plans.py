"""From a plan to flights on the globe: the line that the judge times, as places that an aircraft is told."""

from __future__ import annotations

from dataclasses import dataclass, replace

from sooner.errors import DataFormatError, Fault, InvalidProblemError
from sooner.io.flights import FlightPlan
from sooner.io.georeference import Georeference
from sooner.missions.cell_flights import cell_flight
from sooner.missions.leg_flights import label, leg_flight
from sooner.missions.leg_tracks import leg_track
from sooner.missions.mission_file import Mission
from sooner.missions.score import Score
from sooner.missions.separation import STEP_S, Apart, Separation, separated
from sooner.missions.separations import SeparationSettings

__all__ = ["Flights", "check_place", "flights"]

TRUE_TO = 0.01  # share by which a metre of the projection may differ from one on the ground, untold


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
            plan, notes = (leg_flight if mission.over_legs else cell_flight)(score, number, ground)
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
    tracks = [leg_track(score, number, plan) for number, plan in enumerate(told.plans) if not plan.stays]
    if not tracks:
        return told
    found = separated(tracks, Apart(said.horizontal_m, said.vertical_m, said.wait_s), str(mission.path))
    delays = {track.number: delay for track, delay in zip(tracks, found.delays_s, strict=True)}
    plans = tuple(replace(plan, departs_s=plan.departs_s + delays.get(plan.searcher, 0.0)) for plan in told.plans)
    kept = f"to keep {said.horizontal_m:g} m on the map or {said.vertical_m:g} m in height from others"
    own = list(told.own)
    for track in tracks:
        if delays[track.number]:
            note = f"{track.name}: takes off {delays[track.number]:.0f} s later than planned, {kept}"
            own[track.number] = (*own[track.number], note)
    found = replace(found, delays_s=tuple(delays.get(plan.searcher, 0.0) for plan in plans))
    names = {track.number: track.name for track in tracks}
    return Flights(plans, tuple(own), (*told.shared, *_near(mission, found, names)), found)


def _near(mission: Mission, found: Separation, names: dict[int, str]) -> tuple[str, ...]:
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
