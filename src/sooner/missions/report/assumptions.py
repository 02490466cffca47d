"""What a plan's numbers take for granted, in sentences: where the person may be, what looks detect, how time goes."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

from sooner.belief import BetaGrid
from sooner.missions.mission_file import Mission
from sooner.missions.report.words import metres, percent
from sooner.missions.settings import Drawing, NoFlyCircle, Segments
from sooner.motion.pace import Pace
from sooner.problem.leg_moves import LegMoves

__all__ = ["assumptions"]

LAWS = {
    "seen": "whoever is in view is detected",
    "edged": "whoever is in view is detected; cells at its edge count by the share that is in view",
    "even": "every metre in view adds the same effort, and effort e detects with probability 1 - exp(-e)",
    "cube": "effort falls off with the cube of the distance, and effort e detects with probability 1 - exp(-e)",
}


def assumptions(mission: Mission) -> list[tuple[str, list[str]]]:
    """Headings, and the sentences that belong to each."""
    found = [
        (f"Where {'targets' if mission.belief is None else 'the person'} may be", list(_prior(mission))),
        ("What a look detects", list(_sensor(mission))),
        ("How time is counted", list(_time(mission))),
        ("Where drones may fly", list(_airspace(mission))),
    ]
    return [(heading, sentences) for heading, sentences in found if sentences]


def _prior(mission: Mission) -> Iterator[str]:
    area, height_width = mission.settings.area, mission.problem.grid.shape
    sources = [
        ("the map", area.poc),
        ("the evidence, each cell by itself,", area.evidence),
        ("the segments and their POC", area.segments.file if isinstance(area.segments, Segments) else area.segments),
    ]
    given = [f"{what} {file}" for what, file in sources if file is not None]
    if area.last_known is not None:
        rings = zip(area.last_known.quantiles or [], area.last_known.rings_m or [], strict=False)
        told = ", ".join(f"{percent(share)} within {metres(ring)}" for share, ring in rings)
        given.append(f"distances from where the person was last known to be: {told}")
    if not given:
        given.append("nothing more than the area: the person is anywhere in it alike")
    yield f"From {' and '.join(given)}."
    side = "" if mission.cell_m is None else f" of {mission.cell_m:g} m"
    yield f"The map has {height_width[0]} x {height_width[1]} cells{side}. Within a cell every place is alike."
    if mission.belief is not None:
        yield f"With probability {percent(mission.belief.outside)} the person is not on this map: no flight finds that."
    if isinstance(mission.sight.known, BetaGrid):
        yield "Targets come and go: the evidence is how often one is in view, which looks teach."
    elif mission.belief is None:
        yield "Targets stay where they are, each cell has one or none, and looks err independently of each other."
    else:
        yield "The person stays where they are during the search, and looks at different places miss independently."


def _sensor(mission: Mission) -> Iterator[str]:
    sensor, moves = mission.settings.sensor, mission.problem.searchers[0].moves
    if isinstance(moves, LegMoves):
        swath = moves.swath
        half = mission.problem.grid.cell_m / 2 if swath.law == "edged" else 0.0  # counted in, for cells at the edge
        yield f"The sensor reaches {swath.radius_m - half:.3g} m to each side of the line: {LAWS[swath.law]}."
        strip = f"One straight leg finds as many as a strip of {swath.width_m:.3g} m in which nobody is missed"
        if sensor.sweep_width_m is not None:
            best = float(swath.strength.max()) * (1.0 if swath.law == "cube" else pi * swath.radius_m**2)
            laid = "" if swath.law == "cube" else ": effort as if laid at random, coverage W L / A"
            yield f"Its sweep width W is {best:.3g} m where it sees best{laid}."
        yield f"{strip}, where the sensor sees best."
    elif sensor.radius_m is not None:
        yield f"The sensor reaches {sensor.radius_m:g} m to each side of the line."
    elif sensor.camera is None:
        yield "A look covers the cell below the drone, and nothing beside it."
    glimpse = mission.glimpse
    if not mission.over_legs and not isinstance(mission.sight.known, BetaGrid):
        low, high = float(glimpse.min()), float(glimpse.max())
        told = percent(low) if low == high else f"{percent(low)} to {percent(high)}, by place"
        yield f"One look detects who is there with probability {told}."
    if sensor.false_alarm:
        yield f"A look says yes where nobody is with probability {percent(sensor.false_alarm)}."
    if sensor.correlation:
        yield f"Looks at one place correlate by {sensor.correlation:g}: a second look finds less than the first did."


def _time(mission: Mission) -> Iterator[str]:
    if mission.over_legs:
        yield "Time is that of the legs as they are flown: the drone speeds up, brakes, and stops wherever it turns."
        for number, sortie in enumerate(mission.sorties):
            moves = mission.problem.searchers[number].moves
            if sortie.battery == 0 and isinstance(moves, LegMoves):
                yield _drone(mission, number, moves.pace)
    elif mission.over_regions:
        yield "Time is that of the path as it is flown: the drone speeds up and brakes within its limits."
    elif mission.step_s is None:
        yield "Time is counted in steps from cell to cell; the mission says no speed."
    else:
        yield "Time is level flight at constant speed from cell to cell; corners, take-off and landing cost nothing."
    wind = mission.settings.wind
    if wind is not None:
        yield f"A wind of {wind.speed_mps:g} m/s blows from {wind.from_deg:g} degrees, everywhere and all the time."
    elif mission.over_legs:
        yield "There is no wind."


def _drone(mission: Mission, number: int, pace: Pace) -> str:
    sortie = mission.sorties[number]
    told = f"Drone {sortie.drone} flies {pace.speed_mps:.3g} m/s, {sortie.altitude_m:g} m above the ground"
    if sortie.vehicle is None:
        return told + "; climbing and landing cost nothing, and no battery runs out."
    kept = f"{sortie.vehicle.reserve_s / 60:.1f} of {sortie.vehicle.endurance_s / 60:.1f} minutes are kept as reserve"
    return f"{told} (vehicle {sortie.vehicle.name}); of each battery {kept}."


def _airspace(mission: Mission) -> Iterator[str]:
    area = mission.settings.area
    if area.polygon is not None or area.flight_area is not None:
        yield f"Drones stay within the {'search' if area.flight_area is None else 'flight'} area."
    if area.no_fly is not None:
        drawn = area.no_fly if isinstance(area.no_fly, list) else [area.no_fly]
        yield f"They keep out of the no-fly zones of {', '.join(_file(each) for each in drawn)}."
    if area.margin_m:
        yield f"From both they keep {metres(area.margin_m)}."
    if mission.obstacles is not None:
        yield "Cells with obstacles are not entered."
    if area.elevation is not None:
        yield f"Heights of the ground come from {area.elevation}."
    if mission.over_legs or len(mission.problem.searchers) > 1:
        yield "No other aircraft are known of."


def _file(drawn: str | Drawing | NoFlyCircle) -> str:
    if isinstance(drawn, NoFlyCircle):
        return f"a circle of {metres(drawn.radius_m or 0.0)}"
    return drawn if isinstance(drawn, str) else drawn.file or ""
