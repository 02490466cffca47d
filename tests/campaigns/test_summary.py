"""Rows, tables and the page: what they say is what the trials say."""

import csv
import io
import statistics

import numpy as np
import pytest

from sooner.campaigns.results import Results, collect
from sooner.campaigns.statistics import estimate, paired, rate
from sooner.campaigns.summary import (
    PLACES_APART,
    paired_csv,
    paired_rows,
    summary_csv,
    summary_markdown,
    summary_rows,
)


def flown(planner: str, better: float = 0.0, instance: str = "hills", n: int = 40, failed: int = 0) -> Results:
    def answer(seed: int) -> dict[str, object]:
        luck = float(np.random.default_rng(seed).normal())
        found = luck + better > 0
        return {
            "found": found,
            "pos": 0.5 + better / 10 + luck / 50,
            "time_to_find": 1000.0 + 100 * luck if found else None,
            "timing.seconds": 0.1 + luck**2 + better,
        }

    return collect(instance, planner, 300, ((seed, answer(seed)) for seed in range(n)), failed)


GREEDY, CLIMB, ANNEAL = flown("greedy"), flown("climb", 0.4, failed=2), flown("anneal", 0.8)


def test_a_row_says_what_the_trials_say():
    rows = {row.measure: row for row in summary_rows([CLIMB])}
    times = CLIMB.measures["time_to_find"]
    there = times[~np.isnan(times)]
    row, expected = rows["time_to_find"], estimate(there)
    assert (row.instance, row.planner, row.budget, row.trials, row.failed) == ("hills", "climb", 300, 40, 2)
    assert row.n == len(there) < 40
    assert (row.mean, row.mean_low, row.mean_high) == (expected.value, expected.low, expected.high)
    assert row.median == statistics.median(there)
    assert row.deviation == pytest.approx(statistics.stdev(there))
    assert (row.lowest, row.highest) == (there.min(), there.max())


def test_a_yes_or_no_has_the_success_rate_with_wilsons_interval_and_no_median():
    row = next(row for row in summary_rows([CLIMB]) if row.measure == "found")
    expected = rate(int(CLIMB.measures["found"].sum()), 40)
    assert (row.mean, row.mean_low, row.mean_high) == (expected.value, expected.low, expected.high)
    assert row.median is row.median_low is row.median_high is None
    assert row.yes_no


def test_a_measure_that_no_trial_has_and_a_case_that_never_finished_are_not_hidden():
    empty = Results("hills", "greedy", 90, np.array([1, 2]), {"pos": np.full(2, np.nan)}, frozenset())
    lost = collect("hills", "broken", 90, [], failed=40)
    first, second = summary_rows([empty, lost])
    assert (first.n, first.trials, first.mean) == (0, 2, None)
    assert (second.measure, second.trials, second.failed) == ("", 0, 40)
    page = summary_markdown("Lost", [empty, lost])
    assert "| trials | 2 | 0, 40 set aside |" in page
    assert "0 of 2" in page


def test_one_trial_has_no_deviation():
    [row] = summary_rows([collect("hills", "greedy", None, [(1, {"pos": 0.5})])])
    assert row.deviation is None
    assert row.mean == row.mean_low == row.median == 0.5


def test_every_two_planners_meet_once_per_measure_the_later_held_against_the_earlier():
    rows = paired_rows([GREEDY, CLIMB, ANNEAL, flown("greedy", instance="plain")])
    met = {(row.planner, row.against) for row in rows}
    assert met == {("climb", "greedy"), ("anneal", "greedy"), ("anneal", "climb")}
    assert len(rows) == 3 * 4
    row = next(row for row in rows if row.measure == "pos" and row.planner == "anneal" and row.against == "climb")
    expected = paired(ANNEAL, CLIMB, "pos")
    assert (row.mean, row.mean_low, row.median, row.p_value) == (
        expected.mean.value,
        expected.mean.low,
        expected.median.value,
        expected.p_value,
    )
    assert (row.n, row.wins, row.ties, row.losses) == (40, 40, 0, 0)


def test_planners_that_share_no_seed_are_not_paired():
    late = collect("hills", "late", 300, [(99, {"pos": 0.5})])
    assert paired_rows([GREEDY, late]) == []


@pytest.mark.parametrize(("rows", "text"), [(summary_rows, summary_csv), (paired_rows, paired_csv)])
def test_a_csv_has_a_line_for_each_row_and_leaves_empty_what_is_not_there(rows, text):
    made = rows([GREEDY, CLIMB])
    read = list(csv.DictReader(io.StringIO(text(made))))
    assert len(read) == len(made)
    for line, row in zip(read, made, strict=True):
        assert float(line["mean"]) == pytest.approx(row.mean, rel=1e-9)
        assert line["yes_no"] == ("true" if row.yes_no else "false")
        assert (line["median"] == "") == row.yes_no
        assert line["budget"] == "300"


def test_a_name_with_a_comma_or_a_quote_survives_the_csv():
    odd = 'greedy, "quick"'
    [read] = csv.DictReader(io.StringIO(summary_csv(summary_rows([collect("hills", odd, None, [(1, {"a": 1})])]))))
    assert (read["planner"], read["budget"]) == (odd, "")


def test_the_page_shows_rates_beside_the_means_of_those_that_have_the_number():
    page = summary_markdown("Three planners", [GREEDY, CLIMB, ANNEAL])
    lines = page.splitlines()
    assert lines[0] == "# Three planners"
    assert "120 trials finished, 2 were set aside." in page
    assert "| | greedy | climb | anneal |" in lines
    assert "| trials | 40 | 40, 2 set aside | 40 |" in lines
    order = [line.split("|")[1].strip() for line in lines if line.startswith("| ")]
    assert order.index("found") < order.index("time_to_find, mean of those that have it")
    has = [int(np.isfinite(case.measures["time_to_find"]).sum()) for case in (GREEDY, CLIMB, ANNEAL)]
    assert "| time_to_find, trials that have it | " + " | ".join(f"{n} of 40" for n in has) + " |" in lines
    assert "pos, mean of those" not in page


def test_the_page_holds_every_planner_against_the_first_only():
    page = summary_markdown("Three planners", [GREEDY, CLIMB, ANNEAL])
    assert "| pos | climb | greedy | 40 | +0.04 | +0.04 | 40 / 0 / 0 | < 0.0001 |" in page
    assert "| pos | anneal | greedy |" in page
    assert "| anneal | climb |" not in page


def test_a_measure_that_the_first_planner_lacks_is_compared_among_those_that_have_it():
    cases = [collect("hills", p, 9, [(s, {m: s}) for s in range(5)]) for p, m in (("a", "x"), ("b", "y"), ("c", "y"))]
    assert "| y | c | b | 5 |" in summary_markdown("Some", cases)


def test_what_belongs_to_a_machine_stands_at_the_end_and_only_there():
    page = summary_markdown("Three planners", [GREEDY, CLIMB])
    before, heading, after = page.partition("## Bound to the machine")
    assert heading
    assert "timing." not in before
    assert "timing.seconds, mean" in after
    assert "pos" not in after
    untimed = collect("hills", "greedy", 9, [(1, {"pos": 1})])
    assert "machine" not in summary_markdown("Untimed", [untimed])


def test_many_places_have_a_table_for_each_measure_instead():
    places = [f"hills {number}" for number in range(PLACES_APART + 1)]
    page = summary_markdown(
        "Many", [flown(p, b, place) for place in places for p, b in (("greedy", 0.0), ("climb", 1.0))]
    )
    assert page.count("\n## found\n") == page.count("\n## pos\n") == 1
    assert page.count("\n### timing.seconds\n") == 1
    found = int(GREEDY.measures["found"].sum())
    table = page.partition("## time_to_find")[2].partition("##")[0]
    assert table.count(f"; {found} of 40") == len(places)
    assert table.count("| climb | greedy |") == len(places)


def test_a_name_cannot_break_a_table():
    page = summary_markdown("A | B", [collect("a|b\nc", "x|y", None, [(1, {"p|q": 0.5})])])
    assert "## a\\|b c\n" in page
    assert "| | x\\|y |" in page
    assert "| p\\|q, mean | 0.5 |" in page


def test_no_results_make_a_page_that_says_so():
    assert "0 trials finished, 0 were set aside" in summary_markdown("Nothing yet", [])
    assert summary_csv([]).count("\n") == paired_csv([]).count("\n") == 1
