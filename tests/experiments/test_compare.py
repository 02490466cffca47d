"""Verdicts and reasons, on made-up numbers."""

import pytest

from sooner.experiments.compare import UNEXPLAINED, compare, comparison_markdown
from sooner.experiments.published import Published, Reproduced


def printed(value, table="Table I", row="BA", column="300"):
    return Published(table, row, column, value, "p. 1")


def ours(value, table="Table I", row="BA", column="300"):
    return Reproduced(table, row, column, value, value - 1, value + 1, 10, "abc", "a processor")


@pytest.mark.parametrize(
    ("theirs", "measured", "verdict"),
    [
        ("50.00", 50.01, "same"),
        ("50.00", 52.0, "near"),
        ("50.00", 47.6, "near"),
        ("50", 53, "above"),
        ("50", 40, "below"),
    ],
)
def test_a_number_is_judged_by_its_distance(theirs, measured, verdict):
    (found,) = compare([printed(theirs)], [ours(measured)], [])
    assert found.verdict == verdict
    assert found.difference == pytest.approx(measured - float(theirs))


@pytest.mark.parametrize(("measured", "verdict"), [(0.05, "holds"), (0.2, "does not hold")])
def test_a_limit_from_above_holds_or_does_not(measured, verdict):
    rules = [{"row": "BA", "sense": "limit", "reason": "because"}]
    assert compare([printed("0.1")], [ours(measured)], rules)[0].verdict == verdict


@pytest.mark.parametrize(("measured", "verdict"), [(0.1, "faster"), (3.0, "slower")])
def test_times_are_faster_or_slower(measured, verdict):
    rules = [{"table": "* Speed", "sense": "time", "reason": "because"}]
    found = compare([printed("1.5", "Table I Speed")], [ours(measured, "Table I Speed")], rules)
    assert found[0].verdict == verdict


def test_a_number_that_nobody_measured_is_said_to_be_so():
    (found,) = compare([printed("1")], [], [{"reason": "the scorer is gone"}])
    assert (found.verdict, found.reason, found.difference) == ("not measured", "the scorer is gone", None)


def test_only_numbers_that_differ_carry_a_reason_and_one_without_is_flagged():
    same, differs = compare([printed("50"), printed("50", column="600")], [ours(50.0), ours(60.0, column="600")], [])
    assert (same.reason, differs.reason) == ("", UNEXPLAINED)


def test_later_rules_overrule_earlier_ones_setting_by_setting():
    rules = [{"table": "Table *", "near": 20.0, "reason": "chance"}, {"row": "B?", "reason": "ties"}]
    (found,) = compare([printed("50")], [ours(60.0)], rules)
    assert (found.verdict, found.reason) == ("near", "ties")


def test_the_page_holds_every_number_its_reason_once_and_what_goes_beyond():
    published = [printed("50"), printed("50", column="600")]
    found = compare(published, [ours(60.0), ours(61.0, column="600")], [{"reason": "chance"}])
    page = comparison_markdown("A paper", found, [ours(60.0), ours(83.0, "Beyond", "NewYork108", "anneal")])
    assert page.startswith("# A paper\n")
    assert "| BA | 300 | 50 | 60.00 | 59.00 to 61.00 | 10 | +10.00 | above | (1) |" in page
    assert page.count("chance") == 1
    assert "## Beyond" in page
    assert "| NewYork108 | 83.00 (82.00 to 84.00) |" in page


def test_the_page_names_every_commit_that_stands_in_its_rows():
    from dataclasses import replace

    published = [printed("50"), printed("50", column="600")]
    new, old = ours(50.0), replace(ours(50.0, column="600"), commit="0ld", processor="another")
    beyond = replace(ours(83.0, "Beyond"), commit="mixed and more")
    page = comparison_markdown("A paper", compare(published, [new, old], []), [new, old, beyond])
    assert (
        "not all made by the same commit: 1 by `abc`, 1 by `0ld`, 1 by `mixed` and `more`, on a processor and" in page
    )
    page = comparison_markdown("A paper", compare(published, [new], []), [new])
    assert "Made by commit `abc` on a processor." in page


def test_rows_of_an_installed_package_are_of_an_unknown_commit():
    from dataclasses import replace

    row = replace(ours(50.0), commit="")
    assert "Made by an unknown commit on" in comparison_markdown("A paper", compare([printed("50")], [row], []), [row])


def test_rules_are_checked_as_a_study_is():
    from pydantic import ValidationError

    with pytest.raises(ValidationError, match="reasn"):
        compare([printed("50")], [ours(50.0)], [{"reasn": "x"}])


def test_a_pipe_in_a_name_cannot_break_the_comparison():
    found = compare([printed("50", row="a|b")], [ours(50.0, row="a|b")], [])
    assert "| a\\|b | 300 | 50 |" in comparison_markdown("A | paper", found, [])
