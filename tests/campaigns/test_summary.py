"""Rows, tables and the page: what they say is what the trials say."""

import csv
import io
import statistics

import numpy as np
import pytest

from sooner.campaigns.pairs import paired
from sooner.campaigns.results import Results, collect
from sooner.campaigns.statistics import estimate, rate
from sooner.campaigns.summary import (
    overall_csv,
    overall_rows,
    paired_csv,
    paired_rows,
    summary_csv,
    summary_rows,
)
from sooner.campaigns.summary_page import SPOTS_APART, summary_page


def page_of(title: str, results: list[Results]) -> str:
    return summary_page(title, summary_rows(results), paired_rows(results), overall_rows(results))


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
    page = page_of("Lost", [empty, lost])
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
    page = page_of("Three planners", [GREEDY, CLIMB, ANNEAL])
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
    page = page_of("Three planners", [GREEDY, CLIMB, ANNEAL])
    assert "| pos | climb | greedy | 40 | +0.04 | +0.04 | 40 / 0 / 0 | < 0.0001 |" in page
    assert "| pos | anneal | greedy |" in page
    assert "| anneal | climb |" not in page


def test_a_measure_that_the_first_planner_lacks_is_compared_among_those_that_have_it():
    cases = [collect("hills", p, 9, [(s, {m: s}) for s in range(5)]) for p, m in (("a", "x"), ("b", "y"), ("c", "y"))]
    assert "| y | c | b | 5 |" in page_of("Some", cases)


def test_what_belongs_to_a_machine_stands_at_the_end_and_only_there():
    page = page_of("Three planners", [GREEDY, CLIMB])
    before, heading, after = page.partition("## Bound to the machine")
    assert heading
    assert "timing." not in before
    assert "timing.seconds, mean" in after
    assert "pos" not in after
    untimed = collect("hills", "greedy", 9, [(1, {"pos": 1})])
    assert "machine" not in page_of("Untimed", [untimed])


def test_many_places_have_a_table_for_each_measure_instead():
    places = [f"hills {number}" for number in range(SPOTS_APART + 1)]
    page = page_of("Many", [flown(p, b, place) for place in places for p, b in (("greedy", 0.0), ("climb", 1.0))])
    assert page.count("\n## found\n") == page.count("\n## pos\n") == 1
    assert page.count("\n### timing.seconds\n") == 1
    found = int(GREEDY.measures["found"].sum())
    table = page.partition("## time_to_find")[2].partition("##")[0]
    assert table.count(f"; {found} of 40") == len(places)
    assert table.count("| climb | greedy |") == len(places)


def test_a_name_cannot_break_a_table():
    page = page_of("A | B", [collect("a|b\nc", "x|y", None, [(1, {"p|q": 0.5})])])
    assert "## a\\|b c\n" in page
    assert "| | x\\|y |" in page
    assert "| p\\|q, mean | 0.5 (n = 1) |" in page


def test_no_results_make_a_page_that_says_so():
    assert "0 trials finished, 0 were set aside" in page_of("Nothing yet", [])
    assert summary_csv([]).count("\n") == paired_csv([]).count("\n") == 1


def test_the_page_says_which_test_p_is_and_that_it_is_not_corrected():
    page = page_of("Two", [GREEDY, CLIMB])
    for told in ("exact sign test", "McNemar", "two-sided", "not corrected", "on a fixed map"):
        assert told in page
    assert "sign test" not in page_of("One", [GREEDY])
    assert "same luck" not in page


def test_a_single_trial_is_said_to_be_one_where_its_interval_would_stand():
    page = page_of("One", [collect("hills", "greedy", None, [(1, {"pos": 0.5})])])
    assert "| pos, mean | 0.5 (n = 1) |" in page


def test_notes_stand_at_the_top_of_the_page():
    page = summary_page("Noted", [], [], notes=["results of 2 sources | are mixed"])
    assert page.startswith("# Noted\n\nresults of 2 sources \\| are mixed\n\n0 trials finished")


# All instances together ----------------------------------------------------------------------------------------------


def everywhere(*planners: tuple[str, float], instances: tuple[str, ...] = ("hills", "plain")) -> list[Results]:
    return [flown(planner, better, place) for place in instances for planner, better in planners]


def test_over_all_instances_each_planner_has_the_mean_of_its_means_and_each_pair_its_difference():
    hills = collect("hills", "a", 9, [(seed, {"x": float(seed)}) for seed in range(4)])
    plain = collect("plain", "a", 9, [(seed, {"x": 10.0}) for seed in range(2)])
    other = [collect(place, "b", 9, [(seed, {"x": 1.0}) for seed in range(4)]) for place in ("hills", "plain")]
    mean_a, mean_b, pair = overall_rows([hills, plain, *other])
    assert (mean_a.planner, mean_a.mean, mean_a.instances, mean_a.seeds) == ("a", (1.5 + 10.0) / 2, 2, 4)
    assert (mean_b.planner, mean_b.mean, mean_b.mean_low, mean_b.mean_high) == ("b", 1.0, 1.0, 1.0)
    assert (pair.planner, pair.against, pair.mean) == ("b", "a", ((1.0 - 1.5) + (1.0 - 10.0)) / 2)
    assert mean_a.mean_low < mean_a.mean < mean_a.mean_high


def test_instances_that_share_their_seeds_luck_are_not_taken_for_independent():
    row = next(row for row in overall_rows(everywhere(("greedy", 0.0))) if row.measure == "pos")
    alone = next(row for row in summary_rows([GREEDY]) if row.measure == "pos")
    assert (row.mean, row.mean_low) == (pytest.approx(alone.mean), pytest.approx(alone.mean_low))


def test_a_planner_that_was_not_on_every_instance_is_not_averaged():
    rows = overall_rows([*everywhere(("greedy", 0.0)), CLIMB])
    assert {row.planner for row in rows} == {"greedy"}


def test_one_instance_of_a_budget_has_no_overall():
    assert overall_rows([GREEDY, CLIMB]) == []
    assert "All" not in page_of("One", [GREEDY, CLIMB])


def test_the_page_has_a_section_over_all_instances_of_a_budget():
    page = page_of("Two places", everywhere(("greedy", 0.0), ("climb", 0.4)))
    section = page.partition("## All 2 instances, budget 300")[2].partition("\n## ")[0]
    assert "not a sample" in section
    assert "| | greedy | climb |" in section
    assert "| found | " in section
    assert "| pos | climb | greedy | 40 | +0.04 |" in section
    assert "timing." not in section
    assert "### All 2 instances, budget 300" in page


def test_the_overall_numbers_are_a_csv_too():
    made = overall_rows(everywhere(("greedy", 0.0), ("climb", 0.4)))
    read = list(csv.DictReader(io.StringIO(overall_csv(made))))
    assert [float(line["mean"]) for line in read] == pytest.approx([row.mean for row in made], rel=1e-9)
    assert {line["against"] for line in read} == {"", "greedy"}
