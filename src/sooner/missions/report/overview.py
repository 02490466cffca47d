"""The page of a report for the command post: what the plan is worth, what is left, and what that rests on."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite

from sooner.missions.report.assumptions import assumptions
from sooner.missions.report.drawn import Pictures
from sooner.missions.report.markup import Html, bullets, element, facts, joined, picture, table
from sooner.missions.report.report import Report
from sooner.missions.report.words import amount, coordinates, metres, percent, when

__all__ = ["overview"]

TOLD = (0.25, 0.5, 0.75, 0.9)  # CDPs whose times are told
LEAVES = {
    "probability": "If nobody is found, {} is still on the map.",
    "bits": "After it there are {} still to learn.",
    "targets": "After it, as expected, {} are still on the map.",
}
DOES = {"probability": "finds the person with probability", "bits": "learns", "targets": "finds, as expected"}


def overview(report: Report, pictures: Pictures) -> Html:
    """All sections, one below the other."""
    return joined([*_answer(report), *_flights(report, pictures), *_growth(report, pictures), *_left(report, pictures),
                   *_compared(report), *_rests(report)])  # fmt: skip


def _answer(report: Report) -> Iterator[Html]:
    score, unit = report.score, report.score.mission.sight.unit
    yield element(
        "p",
        "This plan ",
        DOES[unit],
        " ",
        element("strong", amount(unit, score.evaluation.total)),
        class_="answer",
    )
    yield facts(_in_short(report))
    yield bullets(report.notes, class_="notes")


def _in_short(report: Report) -> Iterator[tuple[str, object]]:
    score, mission, unit = report.score, report.score.mission, report.score.mission.sight.unit
    yield from _proved(report)
    lasts = [when(float(score.evaluation.times[-1]) + report.later_s / (mission.unit_s or 1.0), mission.unit_s)]
    flown = sum(sheet.flies for sheet in report.sheets)
    if flown > 1:
        lasts.append(f"{flown} flights, all at their ends by then")
    yield "the search lasts", ", ".join(lasts)
    if mission.belief is not None and unit == "probability":
        yield "never looked at", f"{percent(score.never_looked)} of the probability"
        yield "looked at, and missed", percent(score.missed)
        yield "outside this map", percent(mission.belief.outside)
        times = [(share, score.evaluation.time_to(share)) for share in TOLD]
        for share, time in times:
            if isfinite(time):
                yield f"{share:.0%} found after", when(time, mission.unit_s)


def _proved(report: Report) -> Iterator[tuple[str, object]]:
    score, bound = report.score, report.bound
    mission, target = score.mission, score.mission.problem.objective.target
    if bound is None:
        yield "no flight can pass", "nothing is proved here"
        return
    if target is not None:
        yield f"{target:.3g} is reached after", when(-score.evaluation.value, mission.unit_s)
        told = "it cannot be reached in this time" if not isfinite(bound.value) else when(-bound.value, mission.unit_s)
        yield "no flight gets there before", told
        return
    which = "no flight over these regions passes" if mission.over_regions else "no flight can pass"
    yield which, amount(mission.sight.unit, bound.value)
    if report.gap is not None:
        yield "so this plan is", f"at most {percent(report.gap)} short of the best there is"


def _flights(report: Report, pictures: Pictures) -> Iterator[Html]:
    yield element("h2", "The plan")
    yield picture(pictures.flights(), "The flights over the map of where the person may be; darker is more likely.")
    head = ["flight", "takes off", "flies", "in the air", "places"]
    rows = [
        [
            sheet.name,
            f"T + {when(sheet.departs_s, 1.0)}" if sheet.flies else "stays on the ground",
            metres(sheet.length_m) if report.score.mission.cell_m is not None else "-",
            "-" if sheet.airborne_s is None else when(sheet.airborne_s, 1.0),
            len(sheet.stops),
        ]
        for sheet in report.sheets
    ]
    yield table(head, rows, "T is when the search begins. The colour of a line says when it is flown.")


def _growth(report: Report, pictures: Pictures) -> Iterator[Html]:
    yield element("h2", "How soon")
    yield picture(pictures.growth(), "How what is found grows with time, and the bound that no flight passes.")


def _left(report: Report, pictures: Pictures) -> Iterator[Html]:
    score, mission, unit = report.score, report.score.mission, report.score.mission.sight.unit
    yield element("h2", "What remains, and where")
    total = float(score.left[mission.problem.grid.passable].sum())
    yield element("p", LEAVES[unit].format(amount(unit, total)) + " The richest places left:")
    yield picture(pictures.left(), "What the plan leaves; the richest places are framed and lettered.")
    if not report.places:
        yield element("p", "Nothing worth telling is left on the map.")
        return
    side = "cells" if mission.cell_m is None else metres(report.places[0].side * mission.cell_m) + " square"
    head = ["place", "middle (lat, lon)" if report.places[0].at else "middle", "holds", "held before", "searched"]
    rows = [
        [
            place.letter,
            coordinates(*place.at) if place.at else _on_map(mission.cell_m, place.middle),
            amount(unit, place.left),
            amount(unit, place.before),
            percent(place.searched),
        ]
        for place in report.places
    ]
    yield table(head, rows, f"Places of {report.places[0].side} x {report.places[0].side} cells ({side}).")


def _on_map(cell_m: float | None, middle: tuple[float, float]) -> str:
    unit = "cells" if cell_m is None else "m"
    return f"{middle[0]:.0f} {unit} east, {middle[1]:.0f} {unit} north"


def _compared(report: Report) -> Iterator[Html]:
    """What planning buys, where patterns can be flown."""
    if not report.patterns:
        return
    unit, plan = report.score.mission.sight.unit, report.score.evaluation.total
    yield element("h2", "What planning buys")
    yield element(
        "p",
        "The classic search patterns on this mission: the same drones and batteries, each pattern drawn in several "
        "ways and the best of them kept, all judged alike.",
    )
    rows = [["this plan", amount(unit, plan), "", ""]]
    for each in report.patterns:
        times = f"{plan / each.value:.2f}" if each.value > 0 else "-"
        more = f"{100 * (plan - each.value):+.1f} points" if unit == "probability" else f"{plan - each.value:+.3f}"
        rows.append([each.name + (" *" if each.cut_short else ""), amount(unit, each.value), more, times])
    short = any(each.cut_short for each in report.patterns)
    note = "* cut short: its time was up before every way had been tried; more --seconds may find a better one"
    yield table(["flown as", "finds", "the plan finds more by", "times as much"], rows, note if short else "")
    best = report.patterns[0]
    if best.value > plan:
        told = f"Here {best.name} finds more than this plan: plan for longer, or fly sooner plan --planner {best.name}."
        yield element("p", element("strong", told))


def _rests(report: Report) -> Iterator[Html]:
    """Assumptions and the proof, for whoever must answer for the numbers."""
    yield element("h2", "What these numbers rest on")
    for heading, sentences in assumptions(report.score.mission):
        yield element("h3", heading)
        yield bullets(sentences)
    yield element("h3", "The bound")
    bound = report.bound
    if bound is None:
        yield element("p", "Nothing is proved for a search of this kind.")
        return
    assumes = f" It takes for granted: {bound.assumes}." if bound.assumes else ""
    yield element("p", f"Proved by {bound.proof}: no plan whatever on this map, with these drones, passes it.{assumes}")
    judge = "All figures are those of one judge, who scores any plan alike; they are as good as the map and the sensor."
    yield element("p", judge)
