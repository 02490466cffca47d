"""The study file: every fault told by its key, and what it asks to be flown."""

import re
from pathlib import Path

import pytest

from sooner.campaigns.reference import reference_page
from sooner.campaigns.study import OfCampaign, Rule, Study, StudyFile, Table, read_study
from sooner.campaigns.trial import Case
from sooner.errors import DataFormatError
from sooner.io.reading import MOST_BYTES_OF_TOML

HEAD = """
title = "Small"
trial = "my_trial:fly"
trials = 3
budgets = [40, 80]
"""
REST = """
[instances]
hills = { chance = 0.5 }
plain = { chance = 0.1 }
[planners]
a = { width = 1 }
b = { width = 2 }
"""
SMALL = HEAD + REST


@pytest.fixture
def study(tmp_path):
    """study(text) -> the study, read."""

    def read(text: str = SMALL) -> Study:
        (tmp_path / "study.toml").write_text(text, encoding="utf-8")
        return read_study(tmp_path / "study.toml")

    return read


def faults(study, text: str) -> list[tuple[str, str, str]]:
    with pytest.raises(DataFormatError) as raised:
        study(text)
    assert all(fault.file.endswith("study.toml") for fault in raised.value.faults)
    return [(fault.key, fault.came, fault.expected) for fault in raised.value.faults]


def flown(study: Study, trials: int | None = None) -> dict[tuple[str, str, object], range]:
    return {(case.instance, case.planner, case.budget): seeds for case, seeds in study.asked(trials).cases}


# Faults --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "key", "came", "expected"),
    [
        (HEAD + "seeds = 3" + REST, "seeds", "there is no such key", "docs/study_file.md"),
        (SMALL + "[limits]\ntime = 3", "limits.time", "there is no such key", "docs/study_file.md"),
        (SMALL + "[[tables]]\nname = 'T'\nplaner = ['a']", "tables[0].planer", "there is no such key", "study_file"),
        (SMALL + "[[rules]]\nreasn = 'x'", "rules[0].reasn", "there is no such key", "docs/study_file.md"),
        (SMALL.replace('title = "Small"', ""), "title", "nothing came", "expected this key"),
        (SMALL.replace('"Small"', '""'), "title", "'' came", "text, not empty"),
        (SMALL.replace("trials = 3", "trials = 0"), "trials", "0 came", "greater than or equal to 1"),
        (SMALL.replace("trials = 3", "trials = 2.5"), "trials", "2.5 came", "a whole number"),
        (SMALL.replace("trials = 3", 'trials = "3"'), "trials", "'3' came", "a whole number"),
        (SMALL.replace("trials = 3", "trials = true"), "trials", "True came", "a whole number"),
        (SMALL.replace("[40, 80]", "40"), "budgets", "40 came", "a list"),
        (SMALL.replace("[40, 80]", "[40, nan]"), "budgets[1]", "nan came", "a finite number"),
        (SMALL.replace("[40, 80]", "[inf]"), "budgets[0]", "inf came", "a finite number"),
        (SMALL.replace("[40, 80]", '[40, "80"]'), "budgets[1]", "'80' came", "a finite number"),
        (SMALL.replace("[40, 80]", "[true]"), "budgets[0]", "True came", "a finite number"),
        (SMALL + "[limits]\nseconds = nan", "limits.seconds", "nan came", "a finite number"),
        (SMALL + "[limits]\nseconds = 0", "limits.seconds", "0 came", "greater than 0"),
        (SMALL + "[limits]\nmemory_mb = -1", "limits.memory_mb", "-1 came", "greater than 0"),
        (HEAD + "limits = 3" + REST, "limits", "3 came", "a table"),
        (SMALL.replace('"my_trial:fly"', '"fly"'), "trial", "'fly' came", "module:function"),
        (SMALL.replace('"my_trial:fly"', '"a..b:fly"'), "trial", "'a..b:fly' came", "module:function"),
        (HEAD + 'data_files = ["/etc/*"]' + REST, "data_files[0]", "'/etc/*' came", "below the folder of the data"),
        (SMALL.replace("{ width = 1 }", "1"), "planners.a", "1 came", "a table"),
        (HEAD + "[instances]\n[planners]\na = {}", "instances", "none came", "at least one"),
        (SMALL + "[[tables]]\nplanners = ['a']", "tables[0].name", "nothing came", "expected this key"),
        (SMALL + "[[tables]]\nname = 'T'\nstatistic = 'mode'", "tables[0].statistic", "'mode' came", "'mean'"),
        (SMALL + "[[rules]]\nsense = 'less'", "rules[0].sense", "'less' came", "'limit'"),
        (SMALL + "[[rules]]\nnear = nan", "rules[0].near", "nan came", "a finite number"),
    ],
)
def test_a_fault_is_named_with_its_key_what_came_and_what_was_expected(study, text, key, came, expected):
    ((told_key, told_came, told_expected),) = faults(study, text)
    assert (told_key, told_came) == (key, came)
    assert expected in told_expected


@pytest.mark.parametrize(
    ("more", "key", "came", "expected"),
    [
        ('planners = ["c"]', "planners", "'c' came", "expected some of a, b"),
        ('planners = ["c*"]', "planners", "'c*' came", "expected some of a, b"),
        ("planners = []", "planners", "'' came", "expected some of a, b"),
        ('instances = ["hills", "moon"]', "instances", "'moon' came", "expected some of hills, plain"),
        ('versus = "c"', "versus", "'c' came", "expected one of a, b"),
        ('versus = "*"', "versus", "'*' came", "expected one of a, b"),
        ('versus = "a"\nstatistic = "rate"', "statistic", "'rate' came with versus", "expected mean or median"),
        ('row = "{seed}"', "row", "'{seed}' came", "expected {instance}, {planner}, {budget} and {measure} only"),
        ('row = "{}"', "row", "'{}' came", "expected {instance}, {planner}, {budget} and {measure} only"),
        (
            'column = "{planner"',
            "column",
            "'{planner' came",
            "expected {instance}, {planner}, {budget} and {measure} only",
        ),
        ('column = "{planner.width}"', "column", "'{planner.width}' came", "expected {instance}, "),
        ('column = "{budget:99999999999}"', "column", "'{budget:99999999999}' came", "expected {instance}, "),
    ],
)
def test_a_table_that_names_what_is_not_there_is_refused(study, more, key, came, expected):
    ((told_key, told_came, told_expected),) = faults(study, SMALL + "[[tables]]\nname = 'T'\n" + more)
    assert (told_key, told_came) == (f"tables[0].{key}", came)
    assert told_expected.startswith(expected)


@pytest.mark.parametrize(
    ("a", "key", "came"),
    [
        ("{ width = nan }", "planners.a.width", "nan came"),
        ("{ deep = { list = [1, inf] } }", "planners.a.deep.list[1]", "inf came"),
        ("{ when = 2024-05-01 }", "planners.a.when", "2024-05-01 came"),
        ("{ most_trials = 0 }", "planners.a.most_trials", "0 came"),
        ("{ seeds_factor = 1.5 }", "planners.a.seeds_factor", "1.5 came"),
        ("{ needs = 3 }", "planners.a.needs", "3 came"),
        ("{ needs = '' }", "planners.a.needs", "'' came"),
    ],
)
def test_a_planner_that_no_trial_can_be_told_is_refused(study, a, key, came):
    ((told_key, told_came, _),) = faults(study, SMALL.replace("{ width = 1 }", a))
    assert (told_key, told_came) == (key, came)


@pytest.mark.parametrize("name", ["*", "?", "alph*", "what?"])
@pytest.mark.parametrize(("kind", "old"), [("planners", "a = { w"), ("instances", "hills = { c")])
def test_a_name_that_is_a_pattern_is_refused_as_it_would_swallow_the_others(study, name, kind, old):
    ((key, came, expected),) = faults(study, SMALL.replace(old, f'"{name}" = {old[-3:]}'))
    assert (key, came) == (f"{kind}.{name}", f"the name '{name}' came")
    assert expected.startswith("expected no * or ?")


def test_a_mission_is_named_by_text_and_stands_beside_the_study(study):
    assert faults(study, SMALL.replace("chance = 0.5", "mission = 3"))[0][0] == "instances.hills.mission"
    text = 'data = "maps"' + SMALL.replace("chance = 0.5", 'mission = "m.toml"')
    assert faults(study, text)[0][1:] == ("'m.toml' came with data", "leave data out: missions stand beside the study")


def test_all_faults_are_told_at_once(study):
    text = SMALL.replace("trials = 3", "trials = 0").replace("[40, 80]", "[nan, 'x']") + "[limits]\ntime = 3"
    assert [key for key, _, _ in faults(study, text)] == ["trials", "budgets[0]", "budgets[1]", "limits.time"]
    text = SMALL.replace("width = 1", "width = nan") + "[[tables]]\nname = 'T'\nrow = '{seed}'\nversus = 'c'"
    assert [key for key, _, _ in faults(study, text)] == ["planners.a.width", "tables[0].versus", "tables[0].row"]


def test_faults_of_keys_of_names_and_of_what_cannot_be_flown_are_told_in_one_round(study):
    text = """
    titel = "Small"
    budgets = [0]
    [instances]
    hills = { scenario = "bimodal", width = 3, seed = -1 }
    moon = { scenario = "moon" }
    sea = 3
    [planners]
    a = { name = "anneal", ticks = 0 }
    b = { name = "greedy", most_trials = 0, ticks = 0 }
    [[tables]]
    name = "T"
    instances = ["sea", "sun"]
    [[tables]]
    nam = "U"
    """
    assert {key for key, _, _ in faults(study, text)} == {
        "titel",
        "title",
        "instances.sea",
        "tables[1].name",
        "tables[1].nam",
        "planners.b.most_trials",
        "tables[0].instances",
        "instances.hills.width",
        "instances.hills.seed",
        "instances.moon.scenario",
        "budgets",
        "planners.a",
    }


def test_a_trial_of_sooners_own_that_is_not_there_is_a_fault(study):
    text = SMALL.replace("my_trial:fly", "sooner.experiments.flight:flee") + "[limits]\nseconds = 0"
    assert [key for key, _, _ in faults(study, text)] == ["limits.seconds", "trial"]


def test_modules_that_planners_are_made_from_are_known_but_for_sooners_own(study):
    text = """{ make = "mine.walks:Walk", deep = [{ make = "other:Thing" }], near = { make = "sooner.planners:X" } }"""
    assert study(SMALL.replace("{ width = 1 }", text)).modules == ("mine.walks", "other")


def test_what_came_is_not_told_at_length(study):
    ((_, came, _),) = faults(study, SMALL.replace("trials = 3", f'trials = "{"9" * 10_000}"'))
    assert len(came) < 80


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"title = ", "it is not TOML"),
        (b"\xff\xfe\x00", "something that is not text came"),
        (b"a = " + b"[" * 20_000, "it is not TOML"),
        (SMALL.encode() + b"#" * MOST_BYTES_OF_TOML, "a file of more than 10 MB came"),
    ],
    ids=["broken", "binary", "deep", "huge"],
)
def test_what_is_no_study_is_refused(tmp_path, content, told):
    (tmp_path / "s.toml").write_bytes(content)
    with pytest.raises(DataFormatError, match=told):
        read_study(tmp_path / "s.toml")


def test_a_study_that_is_not_there_is_refused_by_name(tmp_path):
    with pytest.raises(DataFormatError, match=re.escape(str(tmp_path / "study.toml"))):
        read_study(tmp_path)


# What is flown -------------------------------------------------------------------------------------------------------


def test_without_tables_every_instance_meets_every_planner_with_every_budget(study):
    found = flown(study())
    assert set(found) == {(i, p, b) for i in ("hills", "plain") for p in ("a", "b") for b in (40, 80)}
    assert set(found.values()) == {range(3)}
    assert len(study().asked()) == 24


def test_without_budgets_each_case_is_flown_once_without_one(study):
    assert {budget for _, _, budget in flown(study(SMALL.replace("[40, 80]", "[]")))} == {None}


def test_a_budget_is_one_budget_however_often_and_however_it_is_written(study):
    found = study(SMALL.replace("[40, 80]", "[40, 40.0, 80, 40]"))
    assert [(cell.case.budget, type(cell.case.budget)) for cell in found.cells(Table(name="T", planners=["a"]))] == [
        (40, int),
        (80, int),
    ] * 2


def test_a_case_is_told_what_the_study_says_and_not_what_is_for_the_campaign(study):
    text = SMALL.replace("{ width = 1 }", "{ width = 1, most_trials = 2, needs = 'numpy', seeds_factor = 2 }")
    case = next(case for case, _ in study(text).asked().cases if case.planner == "a")
    assert case == Case("hills", "a", 40, '{"instance": {"chance": 0.5}, "planner": {"width": 1}}')


def test_seeds_are_multiplied_and_then_cut(study):
    text = SMALL.replace("{ width = 1 }", "{ seeds_factor = 10 }").replace("{ width = 2 }", "{ most_trials = 2 }")
    assert flown(study(text))["hills", "a", 40] == range(30)
    assert flown(study(text))["hills", "b", 40] == range(2)
    assert flown(study(text), 1)["hills", "a", 40] == range(10)
    both = SMALL.replace("{ width = 1 }", "{ seeds_factor = 10, most_trials = 12 }")
    assert flown(study(both))["hills", "a", 40] == range(12)


def test_a_slice_overrules_the_number_of_the_file(study):
    assert len(study().asked(1)) == 8
    assert len(study().asked(100)) == 800


def test_a_planner_whose_package_is_missing_is_left_out(study):
    text = SMALL.replace("{ width = 2 }", "{ needs = 'no_such_package_at_all.part' }")
    assert {planner for _, planner, _ in flown(study(text))} == {"a"}
    assert {planner for _, planner, _ in flown(study(text.replace("no_such_package_at_all.part", "numpy")))} == {
        "a",
        "b",
    }


def test_what_is_held_against_a_planner_that_is_missing_is_left_out_too(study):
    text = SMALL.replace("{ width = 2 }", "{ needs = 'no_such_package_at_all' }")
    tables = "[[tables]]\nname = 'T'\nversus = 'b'\n[[tables]]\nname = 'U'\nplanners = ['a']\nbudgets = [1]"
    assert set(flown(study(text + tables))) == {("hills", "a", 1), ("plain", "a", 1)}


def test_a_study_of_which_nothing_is_left_says_what_to_install(study):
    text = SMALL.replace("width = 1", "needs = 'no_such_package_at_all'").replace("width = 2", "needs = 'nor_this'")
    with pytest.raises(DataFormatError, match="nothing is left to fly; install no_such_package_at_all, nor_this"):
        study(text).asked()


def test_versus_flies_the_planner_it_is_held_against_first_and_never_against_itself(study):
    read = study(SMALL + "[[tables]]\nname = 'T'\nversus = 'b'\ninstances = ['plain']")
    cells = list(read.cells(read.tables[0]))
    assert [(cell.case.planner, cell.versus.planner) for cell in cells] == [("a", "b"), ("a", "b")]
    assert [case.planner for case, _ in read.asked().cases] == ["b", "a", "b", "a"]


def test_times_are_flown_again_alone_with_seeds_of_their_own(study):
    read = study("timed_trials = 2" + SMALL + "[[tables]]\nname = 'T'\ntimes = 'T Speed'\nplanners = ['a']")
    alone = {case: seeds for case, seeds in read.asked().cases if case.alone}
    assert len(alone) == 4
    assert set(alone.values()) == {range(2)}
    assert {seeds for case, seeds in read.asked(1).cases if case.alone} == {range(1)}


def test_rows_and_columns_are_named_by_their_templates(study):
    read = study(SMALL + "[[tables]]\nname = 'T'\nrow = '{instance}!'\ncolumn = '{planner} {budget} '\nbudgets = [7]")
    cells = list(read.cells(read.tables[0]))
    assert [(cell.row, cell.column) for cell in cells][:2] == [("hills!", "a 7"), ("hills!", "b 7")]


def test_patterns_choose_by_name_and_a_name_in_brackets_is_a_name(study):
    text = SMALL.replace("b = { width = 2 }", '"a[b]" = { width = 2 }\nab = {}')
    assert {p for _, p, _ in flown(study(text + "[[tables]]\nname = 'T'\nplanners = ['a[b]']"))} == {"a[b]"}
    assert {p for _, p, _ in flown(study(text + "[[tables]]\nname = 'T'\nplanners = ['a*']"))} == {"a", "a[b]", "ab"}
    assert {p for _, p, _ in flown(study(text + "[[tables]]\nname = 'T'\nplanners = ['a?']"))} == {"ab"}


def test_only_keeps_the_tables_that_are_asked_for(study):
    read = study(
        SMALL + "".join(f"[[tables]]\nname = '{name}'\nbudgets = [{n}]\n" for n, name in enumerate(("A1", "A2", "B")))
    )
    assert {budget for _, _, budget in flown(read.only(["A*"]))} == {0, 1}
    assert read.only(["*"]).tables == read.tables
    with pytest.raises(DataFormatError, match="Z came; expected some of 'A1', 'A2', 'B'"):
        read.only(["Z"])
    assert study().only(["All"]).asked() == study().asked()


def test_rules_say_only_what_the_file_says(study):
    read = study(SMALL + "[[rules]]\nrow = 'B?'\nnear = 3\n[[rules]]\nreason = 'chance'")
    assert read.rules == ({"row": "B?", "near": 3.0}, {"reason": "chance"})


def test_missions_and_what_they_name_decide_what_comes_out(study, tmp_path):
    (tmp_path / "maps[1]").mkdir()
    (tmp_path / "maps[1]" / "poc.csv").write_text("1")
    (tmp_path / "other.npy").write_text("1")
    mission = "[area]\npoc = 'poc.csv'\nobstacles = '../other.npy'\nname = 'nothing'\ncell_m = 3.0"
    (tmp_path / "maps[1]" / "m.toml").write_text(mission)
    read = study(
        SMALL.replace("chance = 0.5", "mission = 'maps[1]/m.toml'").replace("chance = 0.1", "mission = 'no.toml'")
    )
    found = [file for pattern in read.data_files for file in tmp_path.glob(pattern)]
    assert {file.resolve().relative_to(tmp_path.resolve()).as_posix() for file in found} == {
        "maps[1]/m.toml",
        "maps[1]/poc.csv",
        "other.npy",
    }


# The reference -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", [StudyFile, Table, Rule, OfCampaign])
def test_every_key_is_explained(model):
    page = reference_page()
    for key in model.model_fields:
        assert f"`{key}`" in page or f"[{key}]" in page, key


def test_the_example_of_the_reference_is_a_study(study):
    (text,) = re.findall(r"```toml\n(.*?)```", reference_page(), re.DOTALL)
    assert len(study(text).asked()) == 2 * 2 * 2 * 20


def test_the_studies_of_the_repository_can_be_read():
    for file in (Path(__file__).parents[2] / "benchmarks").rglob("study.toml"):
        assert len(read_study(file).asked())


def test_tables_there_are_are_told_once_each(study):
    two = study(SMALL + 2 * "[[tables]]\nname = 'Twice'\n")
    with pytest.raises(DataFormatError) as raised:
        two.only(["Other"])
    assert str(raised.value).count("'Twice'") == 1
