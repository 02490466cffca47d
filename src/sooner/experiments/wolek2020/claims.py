"""What Wolek et al. say in Table I and in the text, counted in ours; standard errors, and differences seed by seed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from math import sqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sooner.belief.street_kriging import StreetKriging
from sooner.campaigns.results import Results
from sooner.campaigns.run import Ran
from sooner.campaigns.study import Study
from sooner.experiments.wolek2020.curves import Curves
from sooner.experiments.wolek2020.scenes import FLIGHT_TEST, SIMULATED_S, three_blocks
from sooner.simulation import Scene, World
from sooner.simulation.strategies import Information

__all__ = ["AUTHORS", "by_seed", "claims", "mean_and_error"]

Claim = tuple[str, str, str, float, int]
Found = Mapping[tuple[str, str, int | None], Results]
Values = Mapping[tuple[str, str, str], float]
BySeed = dict[int, float]

AUTHORS = ("Randalls Island", "Silver Spring", "New York")
HALF_CELL = tuple(f"{name}, half a cell" for name in AUTHORS)
OTHER = ("West Oakland",)
RANDOM, LAWNMOWER, UNIFORM, KRIGED, KNOWN = (
    "Case 3: random, LRDT", "Case 4: lawnmower, LRDT", "Case 5: information, uniform", "Case 6: information, kriging",
    "Case 7: information, known map",
)  # fmt: skip
TUNED = "tuned lawnmower"
HALVES = ("e_nodes", "e_targets")


def claims(ran: Ran, study: Study, value: Values, data: Path) -> Iterator[Claim]:
    """Table, row, column, value and number of trials of every claim; those of tables that were not run are left out."""
    yield from _table_1()
    found = {(case.instance, case.planner, _whole(case.budget)): each for case, each in ran.results().items()}
    parts: Sequence[Callable[[Found], Iterator[Claim]]] = (
        _simulation, _orders, _table_2, _table_2_half_a_cell, _against_tuned, _by_length, _flight_test,
    )  # fmt: skip
    for part in parts:
        with suppress(KeyError):  # a table that was not run
            yield from part(found)
    with suppress(KeyError):
        yield from _figure_4(Curves(ran))


def _whole(budget: float | None) -> int | None:
    return None if budget is None else int(budget)


def _table_1() -> Iterator[Claim]:
    """What a trial flies with where nothing else is said."""
    plain = Scene(World(three_blocks()))
    agent, walk, strategy, kriging = plain.agents[0], plain.world.walk, Information(), StreetKriging()
    settings = {
        ("Max. speed", "m/s"): agent.v_max,
        ("Max. acceleration", "m/s^2"): agent.a_max,
        ("Sensing radius", "m"): agent.radius_m,
        ("Sampling time", "s"): 1,
        ("Target motion", "c_m"): walk.turn_scale,
        ("Target motion", "c_d"): walk.turn_shape,
        ("Target motion", "p_s"): walk.rest,
        ("Grid cell width", "m"): plain.grid.cell_m,
        ("Detection threshold", ""): plain.estimator.odds,
        ("Sensor sensitivities", "m_Z"): agent.target_sensor.sensitivity,
        ("Sensor sensitivities", "m_G"): agent.map_sensor.sensitivity,
        ("Likelihood decay rate", "alpha"): plain.estimator.decay,
        ("Anisotropy scaling", "a_max, m"): kriging.along_m,
        ("Anisotropy scaling", "a_min, m"): kriging.across_m,
        ("No. Voronoi cells", ""): strategy.tasks,
        ("Path length", "waypoints"): strategy.waypoints,
        ("No. neighbors", ""): strategy.neighbours,
        ("Replan time", "s"): plain.replan_s,
    }
    for (row, column), setting in settings.items():
        yield "Table I", row, column, float(setting), 1
    yield "Text", "simulation", "agents", float(len(plain.agents)), 1
    yield "Text", "simulation", "side of the area, m", plain.grid.shape[0] * plain.grid.cell_m, 1
    yield "Text", "simulation", "mission, s", float(SIMULATED_S), 1


def _simulation(found: Found) -> Iterator[Claim]:
    n = sum(len(found[place, KRIGED, None]) for place in AUTHORS)
    yield "Text", "simulation", "trials per strategy", float(n), n


def by_seed(
    found: Found, places: Sequence[str], planner: str, measure: str, budget: int | None = None, versus: str = ""
) -> BySeed:
    """The mean over maps of what a planner scores under each seed that all of them have flown.

    versus : str      a planner whose score under the same seed on the same map is taken off
    """
    parts = []
    for place in places:
        mine = _scores(found[place, planner, budget], measure)
        theirs = _scores(found[place, versus, budget], measure) if versus else dict.fromkeys(mine, 0.0)
        parts.append({seed: mine[seed] - theirs[seed] for seed in mine.keys() & theirs.keys()})
    seeds = sorted(set.intersection(*(set(part) for part in parts)))
    return {seed: float(np.mean([part[seed] for part in parts])) for seed in seeds}


def _scores(found: Results, measure: str) -> BySeed:
    values = found.measure(measure)
    return {int(seed): float(each) for seed, each in zip(found.seeds, values, strict=True) if not np.isnan(each)}


def mean_and_error(scores: BySeed) -> tuple[float, float]:
    """Mean over seeds and its standard error, which is not a number for a single seed."""
    values = np.array(list(scores.values()))
    return float(values.mean()), float(values.std(ddof=1)) / sqrt(len(values)) if len(values) > 1 else float("nan")


def _rows(table: str, row: str, named: Mapping[str, BySeed], maps: int) -> Iterator[Claim]:
    """A mean and its standard error for each name; the error is left out where there is a single seed."""
    for name, scores in named.items():
        mean, error = mean_and_error(scores)
        yield table, row, name, mean, maps * len(scores)
        if np.isfinite(error):
            yield table, row, f"{name}: standard error", error, maps * len(scores)


def _mean(found: Found, planner: str, measure: str) -> float:
    return mean_and_error(by_seed(found, AUTHORS, planner, measure))[0]


def _orders(found: Found) -> Iterator[Claim]:
    """What Table II is said to show, counted."""
    n = sum(len(found[place, KRIGED, None]) for place in AUTHORS)
    tested = {RANDOM: "Case 1: random, CBHT", LAWNMOWER: "Case 2: lawnmower, CBHT"}
    won = sum(_mean(found, lrdt, "e_targets") > _mean(found, cbht, "e_targets") for lrdt, cbht in tested.items())
    yield "Text", "LRDT above CBHT in E_targ where planning does not adapt", "of 2", won, n
    won = sum(_mean(found, KRIGED, half) > _mean(found, UNIFORM, half) for half in HALVES)
    yield "Text", "kriging above the uniform prior in E_nodes and in E_targ", "of 2", won, n
    others = [*tested.values(), RANDOM, LAWNMOWER, UNIFORM, KRIGED]
    won = sum(_mean(found, KNOWN, "e") > _mean(found, other, "e") for other in others)
    yield "Text", "known map above the other cases in E", "of 6", won, n
    won = sum(_mean(found, KRIGED, half) > _mean(found, other, half) for half in HALVES for other in tested)
    yield "Text", "information above random and lawnmower, in E_nodes and in E_targ", "of 4", won, n


def _table_2(found: Found) -> Iterator[Claim]:
    yield from _cases("Table II again, with standard errors", found, AUTHORS)


def _table_2_half_a_cell(found: Found) -> Iterator[Claim]:
    yield from _cases("Table II with targets half a cell off", found, HALF_CELL)


def _cases(table: str, found: Found, places: Sequence[str]) -> Iterator[Claim]:
    for planner in dict.fromkeys(planner for _, planner, _ in found if planner.startswith("Case")):
        with suppress(KeyError):
            yield from _rows(table, planner, {"E": by_seed(found, places, planner, "e")}, len(places))


def _against_tuned(found: Found) -> Iterator[Claim]:
    """Every planner less the tuned lawnmower under the same seed on the same map."""
    for name, places in (("authors' maps", AUTHORS), ("West Oakland", OTHER)):
        planners = dict.fromkeys(planner for place, planner, budget in found if place in places and budget is None)
        for planner in planners:
            if planner in (TUNED, KNOWN):
                continue
            with suppress(KeyError):
                named = {
                    half: by_seed(found, places, planner, measure, versus=TUNED)
                    for half, measure in (("E", "e"), ("E_nodes", "e_nodes"), ("E_targ", "e_targets"))
                }
                yield from _rows(f"Less the tuned lawnmower, {name}", planner, named, len(places))


def _by_length(found: Found) -> Iterator[Claim]:
    """Section V: information against the two that do not learn, in short missions and in long ones."""
    for budget in sorted(budget for place, planner, budget in found if budget and planner == "information"):
        if (AUTHORS[0], "information", budget) in found:
            for measure, name in (("e", "E"), ("nodes_end", "nodes in the end")):
                named = {
                    f"less {other}": by_seed(found, AUTHORS, "information", measure, budget, other)
                    for other in ("random", "lawnmower", "lawnmower, to and fro")
                }
                yield from _rows(f"Section V: {name}, information", f"{budget} s", named, len(AUTHORS))


def _figure_4(curves: Curves) -> Iterator[Claim]:
    """Which of cases 3, 4 and 6 has detected the most at each time, and by how much at first and in the end."""
    nodes = {planner: curves.nodes(planner, AUTHORS).mean(axis=0) for planner in (RANDOM, LAWNMOWER, KRIGED)}
    targets = {planner: curves.targets(planner, AUTHORS) for planner in nodes}
    n, t = len(curves.nodes(KRIGED, AUTHORS)), curves.times
    row = "Fig. 4a: information has detected the most nodes from 25 to 75 % of the mission"
    yield "Text", row, "% of these times", _led(nodes, (t >= 0.25) & (t <= 0.75)), n
    row = "Fig. 4b: information has detected the most targets in the latter half"
    yield "Text", row, "% of these times", _led(targets, t >= 0.5), n
    early = 100.0 * float((targets[KRIGED] - targets[RANDOM])[t <= 0.5].mean())
    row = "Fig. 4b: targets detected in the first half by information less those by random"
    yield "Text", row, "mean, %", early, n
    first = 100.0 * float((nodes[KRIGED] - nodes[RANDOM])[t <= 0.1].mean())
    row = "Section V, at first: nodes detected in the first tenth by information less those by random"
    yield "Text", row, "mean, %", first, n
    row = "Section V, given time: nodes detected in the end by lawnmower above those by information"
    yield "Text", row, "1 yes, 0 no", float(nodes[LAWNMOWER][-1] > nodes[KRIGED][-1]), n
    row = "Section V, given time: targets detected in the end by information less those by lawnmower"
    yield "Text", row, "%", 100.0 * float(targets[KRIGED][-1] - targets[LAWNMOWER][-1]), n
    for planner in nodes:
        yield from _quarters(curves, planner)


def _quarters(curves: Curves, planner: str) -> Iterator[Claim]:
    """The curves of Fig. 4 at the end of each quarter."""
    nodes, targets = curves.nodes(planner, AUTHORS), curves.targets(planner, AUTHORS)
    for quarter in range(1, 5):
        at = quarter * (len(curves.times) - 1) // 4
        column, n = f"{25 * quarter} % of the mission", len(nodes)
        yield "Fig. 4a: nodes detected, mean, %", planner, column, 100.0 * float(nodes[:, at].mean()), n
        yield "Fig. 4a: nodes detected, deviation, %", planner, column, 100.0 * float(nodes[:, at].std(ddof=1)), n
        yield "Fig. 4b: targets detected, %", planner, column, 100.0 * float(targets[at]), n


def _led(curves: Mapping[str, NDArray[np.float64]], when: NDArray[np.bool_]) -> float:
    """Percentage of these times at which the curve of information is above the others."""
    rivals = np.maximum(curves[RANDOM], curves[LAWNMOWER])
    return 100.0 * float((curves[KRIGED] > rivals)[when].mean())


def _flight_test(found: Found) -> Iterator[Claim]:
    """The flight test was one flight; ours are many, each with a target that starts elsewhere."""
    flown = found[FLIGHT_TEST, "information, kriging", None]
    n = len(flown)
    for row, measure in (("all nodes detected after s", "all_nodes_s"), ("target detected after s", "found_s")):
        if not np.isnan(flown.measure(measure)).all():
            yield "Text", "flight test", row, float(np.nanmedian(flown.measure(measure))), n
    by_half = 100.0 * float(flown.measure("by_half").mean())
    yield "Text", "flight test", "nodes detected by half time, %", by_half, n
    for row, measure in (("connected subgraphs", "parts"), ("isolated target states", "alone")):
        yield "Text", "flight test", f"{row} after a quarter", float(flown.measure(measure).mean()), n
