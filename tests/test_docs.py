"""Every lesson runs, every page says what is so."""

import json
import re
import shlex
import sys
from dataclasses import fields
from pathlib import Path

import pytest

from sooner.bibliography import BIBLIOGRAPHY
from sooner.campaigns.reference import reference_page as study_file_page
from sooner.campaigns.report import COLUMNS, REPORT
from sooner.campaigns.summary import OverallRow, PairedRow, SummaryRow
from sooner.cli.main import run
from sooner.experiments.published import Reproduced
from sooner.io.occupancy_graphs import read_street_map, street_map_json
from sooner.missions.reference import reference_page
from sooner.planners.registry import PLANNERS
from sooner.scenarios import SCENARIOS

ROOT = Path(__file__).parent.parent
LESSONS = sorted((ROOT / "docs" / "lessons").glob("*.md"))
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"^```(\S+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda path: path.stem)
def test_a_lesson_runs_from_top_to_bottom(lesson, tmp_path, monkeypatch):
    """Python runs, `sooner` commands run, and a block that names a file is that file."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    planners, modules = dict(PLANNERS), set(sys.modules)
    names = {"__name__": lesson.stem}
    try:
        for language, file, text in BLOCK.findall(lesson.read_text(encoding="utf-8")):
            if file:
                (tmp_path / file).write_text(text, encoding="utf-8")
            elif language == "python":
                exec(compile(text, f"{lesson.name}", "exec"), names)
            elif language == "sh":
                for line in text.splitlines():
                    program, *arguments = shlex.split(line, comments=True)
                    assert program == "sooner"
                    assert run(arguments) == 0, line
    finally:
        PLANNERS.clear()
        PLANNERS.update(planners)
        for name in set(sys.modules) - modules:
            if Path(getattr(sys.modules[name], "__file__", None) or "/").is_relative_to(tmp_path):
                del sys.modules[name]


def test_lessons_are_numbered_without_a_gap():
    assert [int(lesson.name[:2]) for lesson in LESSONS] == list(range(1, len(LESSONS) + 1))


def test_the_mission_file_is_explained_as_it_is_checked():
    told = (ROOT / "docs" / "mission_file.md").read_text(encoding="utf-8")
    assert told == reference_page(), "write docs/mission_file.md anew from sooner.missions.reference.reference_page()"


def test_the_streets_that_are_explained_can_be_read(tmp_path):
    page = (ROOT / "docs" / "mission_file.md").read_text(encoding="utf-8")
    (text,) = [text for language, _, text in BLOCK.findall(page) if language == "json"]
    (tmp_path / "streets.json").write_text(text, encoding="utf-8")
    streets = read_street_map(tmp_path / "streets.json")
    assert (streets.name, streets.south_west, streets.graph.n_edges) == ("Two blocks", (46.1, 11.2), 3)
    assert [streets.graph.grid.cell(cell) for cell in streets.graph.cells] == [(0, 3), (1, 2), (2, 0), (2, 1)]
    written = json.loads(street_map_json(streets))
    assert set(json.loads(text)) <= set(written)
    assert {key for key in written if f"`{key}`" not in page} == set()


def test_the_study_file_is_explained_as_it_is_checked():
    told = (ROOT / "docs" / "study_file.md").read_text(encoding="utf-8")
    assert told == study_file_page(), "write docs/study_file.md anew from sooner.campaigns.reference.reference_page()"


def test_every_column_that_a_campaign_writes_is_explained():
    told = (ROOT / "docs" / "campaign_files.md").read_text(encoding="utf-8")
    sections = {part.partition("\n")[0]: part for part in told.split("\n## ")}
    columns = {
        "`trials.csv`": list(COLUMNS),
        "`summary.csv`": [column.name for column in fields(SummaryRow)],
        "`paired.csv`": [column.name for column in fields(PairedRow)],
        "`overall.csv`": [column.name for column in fields(OverallRow)],
        "`tables.csv`": [column.name for column in fields(Reproduced)],
    }
    for file, names in columns.items():
        cells = [line.split("|")[1] for line in sections[file].splitlines() if line.startswith("| `")]
        assert {name for cell in cells for name in re.findall(r"`(\w+)`", cell)} == set(names), file
    for file in (*REPORT, "tables.md", "tables.csv"):
        assert f"`{file}`" in sections["# The files of a campaign"]


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_every_link_within_the_repository_leads_somewhere(page):
    text = re.sub(BLOCK, "", page.read_text(encoding="utf-8"))
    for link in re.findall(r"\]\(([^)#]+)", text):
        assert link.startswith("http") or (page.parent / link).exists(), f"{page.name} links to {link}"


def test_how_to_choose_lists_every_planner_with_its_sentence():
    lesson = (ROOT / "docs" / "lessons" / "03_how_to_choose_a_planner.md").read_text(encoding="utf-8")
    for name, entry in PLANNERS.items():
        assert f"| `{name}` | {entry.when} |" in lesson


def test_the_readme_names_every_scenario():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for name in SCENARIOS:
        assert f"`{name}`" in readme


def test_every_work_that_is_cited_stands_in_the_bibliography():
    for path in sorted((ROOT / "src").rglob("*.py")):
        for key in re.findall(r"\[([A-Z][A-Za-z]+\d{4})\b", path.read_text(encoding="utf-8")):
            assert key in BIBLIOGRAPHY or key == "Key1975", f"{path.name} cites [{key}]"
    for name, entry in PLANNERS.items():
        assert set(entry.cites) <= set(BIBLIOGRAPHY), name
