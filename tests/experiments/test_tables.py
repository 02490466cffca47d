"""Tables of a study: each cell is the statistic of the trials behind it."""

import numpy as np
import pytest

from sooner.campaigns.pooling import pooled
from sooner.campaigns.statistics import estimate, rate
from sooner.campaigns.study import read_study
from sooner.errors import DataFormatError
from sooner.experiments.tables import tables, tables_files
from tests.campaigns.filled import filled

HEAD = """
title = "Small"
trials = 5
budgets = [40, 80]
[instances]
hills = {}
plain = {}
[planners]
a = {}
b = { most_trials = 4 }
"""
A, B = [0.0, 1.0, 2.0, 3.0, 10.0], [1.0, 3.0, 5.0, 7.0]


def answer(trial):
    value = (A if trial.case.planner == "a" else B)[trial.seed]
    return {
        "value": value + (trial.budget or 0) / 40 - 1,
        "found": trial.seed > 1,
        "late": value if trial.seed else None,
        "timing": {"seconds": 0.5 if trial.case.alone else 99.0},
    }


@pytest.fixture
def made(tmp_path):
    """made(tables, answer) -> rows of the tables by table, row and column."""

    def of(text, said=answer):
        (tmp_path / "study.toml").write_text(HEAD + text, encoding="utf-8")
        study = read_study(tmp_path)
        with filled(study, tmp_path / "out", said) as ran:
            return {row.key: row for row in tables(study, ran)}

    return of


ONE = "[[tables]]\nname = 'T'\ninstances = ['hills']\nbudgets = [40]\n"


def told(row):
    return row.value, row.low, row.high, row.n


def expected(found):
    return found.value, found.low, found.high, found.n


@pytest.mark.parametrize("statistic", ["mean", "median"])
def test_a_cell_is_the_mean_or_the_median_of_its_trials_with_the_interval(made, statistic):
    rows = made(f"{ONE}statistic = '{statistic}'")
    assert set(rows) == {("T", "a", "hills 40"), ("T", "b", "hills 40")}
    assert told(rows["T", "a", "hills 40"]) == expected(estimate(A, statistic))
    assert told(rows["T", "b", "hills 40"]) == expected(estimate(B, statistic))


def test_a_rate_has_wilsons_interval(made):
    row = made(ONE + "measure = 'found'\nstatistic = 'rate'\nplanners = ['a']")["T", "a", "hills 40"]
    assert told(row) == expected(rate(3, 5))


def test_a_rate_of_what_is_no_yes_or_no_is_refused(made):
    with pytest.raises(DataFormatError, match=r"T\.statistic: 'value' came for a rate, and it is no yes or no"):
        made(ONE + "statistic = 'rate'")


def test_a_row_tells_the_commit_and_the_processor(made):
    row = made(ONE)["T", "a", "hills 40"]
    assert (row.commit, row.processor) == ("abc", "a processor")


def test_cells_of_one_name_are_pooled(made):
    rows = made("[[tables]]\nname = 'T'\nplanners = ['a']\ncolumn = 'all'")
    parts = [(np.arange(5), np.array(A) + more) for _ in range(2) for more in (0.0, 1.0)]
    assert list(rows) == [("T", "a", "all")]
    assert told(rows["T", "a", "all"]) == expected(pooled(parts))
    assert rows["T", "a", "all"].n == 20


def test_pooling_identical_places_makes_the_interval_no_narrower(made):
    both = made("[[tables]]\nname = 'T'\nbudgets = [40]\ncolumn = 'all'")["T", "a", "all"]
    one = made(ONE + "column = 'all'")["T", "a", "all"]
    assert (both.n, one.n) == (10, 5)
    assert (both.value, both.low, both.high) == pytest.approx((one.value, one.low, one.high))


def test_pooled_rates_and_differences_keep_a_seeds_trials_together_too(made):
    pool, one = "[[tables]]\nname = 'T'\nbudgets = [40]\ncolumn = 'all'\n", ONE + "column = 'all'\n"
    for more, row in (("measure = 'found'\nstatistic = 'rate'", "a"), ("versus = 'a'", "b")):
        both, alone = (made(text + more)["T", row, "all"] for text in (pool, one))
        assert both.n == 2 * alone.n
        assert (both.low, both.high) == pytest.approx((alone.low, alone.high))


def test_a_case_that_is_named_twice_counts_once(made):
    assert made(ONE.replace("[40]", "[40, 40.0]"))["T", "a", "hills 40"].n == 5


def test_versus_gives_paired_differences_over_shared_seeds(made):
    rows = made(ONE + "versus = 'a'")
    assert list(rows) == [("T", "b", "hills 40")]
    assert told(rows["T", "b", "hills 40"]) == expected(estimate([1.0, 2.0, 3.0, 4.0]))


def test_a_trial_without_the_number_is_left_out(made):
    rows = made(ONE + "measure = 'late'")
    assert told(rows["T", "a", "hills 40"]) == expected(estimate(A[1:]))
    assert made(ONE + "measure = 'late'\nversus = 'a'")["T", "b", "hills 40"].n == 3


def test_a_cell_without_a_finished_trial_has_no_row(made):
    rows = made(ONE, lambda trial: None if trial.case.planner == "a" else answer(trial))
    assert list(rows) == [("T", "b", "hills 40")]
    assert made(ONE + "measure = 'no such'") == {}


def test_times_are_of_the_trials_flown_alone(made):
    rows = made(ONE + "times = 'T Speed'")
    row = rows["T Speed", "a", "hills 40"]
    assert (row.value, row.n) == (0.5, 3)
    assert rows["T", "a", "hills 40"].n == 5


def test_a_study_with_tables_of_its_own_has_them_as_a_page_and_as_numbers(tmp_path):
    (tmp_path / "study.toml").write_text(HEAD + ONE + "row = '{planner} in {instance}'", encoding="utf-8")
    study = read_study(tmp_path)
    with filled(study, tmp_path / "out", answer) as ran:
        files = tables_files(study, ran)
    page = files["tables.md"].decode()
    assert "## T\n\n| | hills 40 |\n|---|---:|\n| a in hills | 3.20 (" in page
    assert files["tables.csv"].decode().startswith("table,row,column,value,")


def test_a_study_without_tables_of_its_own_has_no_page_of_them(tmp_path):
    (tmp_path / "study.toml").write_text(HEAD, encoding="utf-8")
    study = read_study(tmp_path)
    with filled(study, tmp_path / "out", answer) as ran:
        assert tables_files(study, ran) == {}


def page(tmp_path, text, said=answer):
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    study = read_study(tmp_path)
    with filled(study, tmp_path / "out", said) as ran:
        return tables_files(study, ran)["tables.md"].decode()


def test_a_measure_that_no_trial_has_is_said_in_place_of_its_table(tmp_path):
    told = page(tmp_path, f"{HEAD}{ONE}measure = 'valeu'\n{ONE.replace('T', 'U')}".replace("nameU", "name"))
    assert "## T\n\nno trial has a number called 'valeu'; they have 'value', 'found', 'timing.seconds', 'late'" in told
    assert "## U\n\n| | hills 40 |" in told


def test_one_misspelt_measure_among_several_is_said_above_the_tables(tmp_path):
    told = page(tmp_path, f"{HEAD}{ONE}column = '{{measure}}'\nmeasures = {{ good = 'value', bad = 'valeu' }}")
    assert "T: no trial has a number called 'valeu'; they have 'value'" in told
    assert "| | good |" in told


def test_a_table_without_a_finished_trial_says_so(tmp_path):
    assert "## T\n\nno trial has 'value' to show" in page(tmp_path, HEAD + ONE, lambda trial: None)


def test_n_is_that_of_the_cell_where_cells_differ_and_of_the_table_where_not(tmp_path):
    told = page(tmp_path, HEAD + ONE)
    assert "; n = 5) |" in told
    assert "; n = 4) |" in told
    assert "\nn = " not in told
    told = page(tmp_path, HEAD + ONE + "planners = ['b']")
    assert told.endswith("\n\nn = 4\n")
    assert "; n = 4)" not in told


def test_a_name_with_a_pipe_or_a_line_end_cannot_break_a_table(tmp_path):
    odd = HEAD.replace("hills = {}", '"hi|l\\nls" = {}').replace('"Small"', '"A | B"')
    told = page(tmp_path, odd + "[[tables]]\nname = 'T|U'\nbudgets = [40]\nrow = '{planner} | x'")
    assert told.startswith("# A \\| B\n")
    assert "## T\\|U\n\n| | hi\\|l ls 40 | plain 40 |" in told
    assert "| a \\| x | " in told
