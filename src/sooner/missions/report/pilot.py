"""The page of a report for one pilot: what to fly, and blanks to fill by hand."""

from __future__ import annotations

from collections.abc import Iterator

from sooner.missions.report.drawn import Pictures
from sooner.missions.report.markup import Html, bullets, element, facts, joined, picture, table
from sooner.missions.report.report import Report
from sooner.missions.report.sheet import Sheet, Stop
from sooner.missions.report.words import clock, coordinates, metres

__all__ = ["pilot_page"]

MOST_ROWS = 300  # of a table of legs; of more nobody reads them, and the exported file has them all
BLANKS = (
    ("Pilot", "Observer"),
    ("Aircraft", "Battery"),
    ("T by the clock", "Took off at"),
    ("Landed at", "Battery left, %"),
    ("Radio channel", "Post, phone"),
    ("Rescue, phone", "Land else at"),
)
ABOUT_PLACES = "Degrees of WGS 84; bearings from true north; time since the first place; height above the launch."
ENDS = {
    "return": "flies back to where it took off, and lands there",
    "land": "lands at the last place",
    "loiter": "circles at the last place until the pilot lands it",
}


def pilot_page(report: Report, sheet: Sheet, which: tuple[int, int], pictures: Pictures) -> Html:
    """One flight: the first number of so many."""
    mission = report.score.mission
    parts = [
        element("p", f"{mission.name}, sheet {which[0]} of {which[1]}", class_="running"),
        element("h2", "Pilot: ", sheet.name),
        facts(_facts(sheet, mission.cell_m is not None)),
        bullets(_notes(sheet, mission.cell_m is not None), class_="notes"),
        picture(pictures.one(sheet), "The flight with its places numbered as in the table below."),
        _blanks(),
        element("h3", "Places and legs"),
        _legs(sheet, mission.cell_m is not None),
    ]
    return element("section", joined(parts), class_="pilot")


def _facts(sheet: Sheet, scaled: bool) -> Iterator[tuple[str, object]]:
    flight, sortie = sheet.flight, sheet.sortie
    yield "launch", _place(sheet.stops[0], scaled) if flight is None else coordinates(*flight.home)
    yield "take-off", f"T + {clock(sheet.departs_s)}, T being when the search begins"
    if flight is not None:
        yield "height", flight.height
        if flight.home_altitude_m is not None:
            yield "launch lies", f"{flight.home_altitude_m:.0f} m above the sea"
    if sortie is not None:
        yield "above the ground", f"{sortie.altitude_m:g} m"
    if flight is not None and flight.speed_mps is not None:
        yield "speed", f"{flight.speed_mps:.3g} m/s"
    yield "way", metres(sheet.length_m) if scaled else "the mission says no metres"
    yield from _in_the_air(sheet)
    yield "at the end", ENDS[flight.finish] if flight is not None else f"at {_place(sheet.stops[-1], scaled)}"
    if flight is not None and flight.finish != "return":
        yield "landing", _place(sheet.stops[-1], scaled)


def _in_the_air(sheet: Sheet) -> Iterator[tuple[str, object]]:
    """Time on legs, and what is left of the battery then."""
    if sheet.flying_s is None:
        yield "in the air", "the mission says no speed"
        return
    sortie = sheet.sortie
    airborne = sheet.airborne_s or 0.0
    if sortie is None or not sortie.takeoff_s + sortie.landing_s:
        yield "time on legs", f"{clock(sheet.flying_s)}, without climbing and landing"
    else:
        parts = f"climb {clock(sortie.takeoff_s)}, legs {clock(sheet.flying_s)}, landing {clock(sortie.landing_s)}"
        yield "in the air", f"{clock(airborne)}: {parts}"
        yield "on the ground again", f"T + {clock(sheet.departs_s + airborne)}"
    if sortie is not None and sortie.vehicle is not None:
        vehicle = sortie.vehicle
        left = vehicle.endurance_s - airborne
        yield "aircraft", vehicle.name
        yield "battery", f"lasts {clock(vehicle.endurance_s)}; {clock(left)} of it is left at landing"
        yield "reserve", f"{clock(vehicle.reserve_s)} of it, which no plan uses"


def _notes(sheet: Sheet, scaled: bool) -> list[str]:
    if sheet.flight is None:
        return [f"East and north are {'metres' if scaled else 'cells'} from the middle of the map's south-west cell."]
    return [*sheet.notes, "Fly the exported file; this sheet is to check it, and to fly on when it fails."]


def _legs(sheet: Sheet, scaled: bool) -> Html:
    """Every place in order, with the leg that leads to it."""
    placed = sheet.flight is not None
    head = ["place", "lat, lon" if placed else "east, north", "bearing", "leg", "from the start", "time"]
    head += ["height", "m/s"] if placed else []
    rows, flown = [], 0.0
    for number, stop in enumerate(sheet.stops[:MOST_ROWS]):
        flown += stop.leg_m
        rows.append([*_row(number, stop, flown, scaled), *(_aloft(stop) if placed else [])])
    more = len(sheet.stops) - MOST_ROWS
    told = ABOUT_PLACES if placed else ""
    return table(head, rows, told + (f" {more:,} more places stand in the exported file." if more > 0 else ""))


def _row(number: int, stop: Stop, flown: float, scaled: bool) -> list[object]:
    held = f", holds {stop.hold_s:.0f} s" if stop.hold_s else ""
    return [
        number,
        _place(stop, scaled) + held,
        "-" if stop.bearing_deg is None else f"{round(stop.bearing_deg) % 360:03d}°",
        f"{stop.leg_m:.0f} m" if scaled else "-",
        metres(flown) if scaled else "-",
        "-" if stop.time_s is None else clock(stop.time_s),
    ]


def _aloft(stop: Stop) -> list[object]:
    height = "-" if stop.altitude_m is None else f"{stop.altitude_m:.0f} m"
    return [height, "-" if stop.speed_mps is None else f"{stop.speed_mps:.3g}"]


def _place(stop: Stop, scaled: bool) -> str:
    if stop.at is not None:
        return coordinates(*stop.at)
    east, north = stop.metres
    return f"{east:.0f}, {north:.0f} m" if scaled else f"{east:.0f}, {north:.0f} cells"


def _blanks() -> Html:
    """What is only known when it is flown."""
    rows = (
        element("tr", *(cell for name in pair for cell in (element("th", name, scope="row"), element("td", ""))))
        for pair in BLANKS
    )
    seen = element("tr", element("th", "Seen, and where", scope="row"), element("td", "", colspan=3))
    return element("table", element("tbody", *rows, seen), class_="blanks")
