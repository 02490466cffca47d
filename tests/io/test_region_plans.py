"""Plans over regions as files."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import DataFormatError
from sooner.io import read_region_plan, region_plan_csv
from sooner.io.region_plans import HEADER, stages
from sooner.planners import solve
from sooner.planners.region_greedy import RegionGreedy
from sooner.problem import Plan, SearchProblem, evaluate
from tests.planners.region_worlds import region_world


@pytest.fixture
def flown(tmp_path):
    """(problem, plan, path of its file, its lines)."""
    problem = region_world(1, 4, 60.0, legs=True, ends=True)
    plan = solve(problem, RegionGreedy()).best.plan
    path = tmp_path / "plan.csv"
    path.write_bytes(region_plan_csv(plan, problem))
    return problem, plan, path, path.read_text().splitlines()


@settings(max_examples=20)
@given(seed=st.integers(0, 500), legs=st.booleans(), ends=st.booleans())
def test_what_is_written_is_read_back(tmp_path_factory, seed, legs, ends):
    problem = region_world(seed, 4, 40.0, legs=legs, ends=ends)
    problem = SearchProblem(problem.grid, problem.gains, problem.searchers * 2)
    plan = Plan(
        solve(problem.__class__(problem.grid, problem.gains, problem.searchers[:1]), RegionGreedy()).best.plan.actions
        * 2
    )
    path = tmp_path_factory.mktemp("plans") / "plan.csv"
    path.write_bytes(region_plan_csv(plan, problem))
    assert read_region_plan(path, problem) == plan


def test_a_line_says_where_and_when_what_is_flown_ends(flown):
    problem, plan, _, lines = flown
    assert lines[0] == "searcher,action,kind,region,row,col,time_s"
    kinds = [line.split(",")[2] for line in lines[1:]]
    assert kinds[:2] == ["start", "depart"]
    assert kinds[-1] == "return"
    assert len(kinds) == len(plan.actions[0]) + 3
    times = [float(line.split(",")[-1]) for line in lines[1:]]
    assert times[0] == 0.0
    assert (np.diff(times) > 0).all()
    assert times[-1] == pytest.approx(problem.searcher.moves.seconds(plan.actions[0]), abs=1e-3)
    assert tuple(map(int, lines[-1].split(",")[4:6])) == problem.searcher.end


def test_actions_alone_without_places_and_times_are_a_plan(flown):
    problem, plan, path, lines = flown
    bare = [line.split(",")[:4] for line in lines[1:]]
    bare = [fields for fields in bare if fields[2] in ("search", "traverse")]
    rows = [f"0,{step},{kind},{region},,," for step, (_, _, kind, region) in enumerate(bare)]
    path.write_text("\n".join([",".join(HEADER), *rows]))
    assert read_region_plan(path, problem) == plan
    assert evaluate(problem, plan).value > 0


def changed(lines, number, field, value):
    fields = lines[number].split(",")
    fields[field] = value
    return [*lines[:number], ",".join(fields), *lines[number + 1 :]]


def broken(lines, kind, field, value):
    number = next(n for n, line in enumerate(lines) if line.split(",")[2] == kind)
    return changed(lines, number, field, value)


SPOILED = {
    "another header": (lambda lines: ["a,b", *lines[1:]], "line 1: 'a,b' came"),
    "nothing below it": (lambda lines: lines[:1], "without actions"),
    "an unknown kind": (lambda lines: broken(lines, "search", 2, "hover"), "one of start, depart, search"),
    "half an action": (lambda lines: changed(lines, 3, 1, "1.5"), "line 4"),
    "a gap in the numbers": (lambda lines: changed(lines, 3, 1, "7"), "action 7 of searcher 0 came; expected action 2"),
    "a region far off": (lambda lines: broken(lines, "search", 3, "99"), "search 99 came in region"),
    "a way that is none": (lambda lines: broken(lines, "traverse", 3, "99"), "traverse to one of"),
    "another place": (lambda lines: broken(lines, "search", 5, "999"), "as this mission cuts its ground"),
    "quicker than it can be": (
        lambda lines: changed(lines, len(lines) - 1, 6, "1.0"),
        "when a drone that flies as this",
    ),
    "no number of seconds": (lambda lines: changed(lines, 3, 6, "soon"), "line 4"),
    "a second drone": (lambda lines: [*lines, "1,0,search,0,,,"], "a plan for 2 searchers came; expected 1"),
    "a drone left out": (lambda lines: [*lines, "5,0,search,0,,,"], "numbered from 0"),
    "two starts": (lambda lines: [*lines, f"0,{len(lines) - 1},start,0,,,"], "flies no such leg"),
    "nothing": (lambda lines: [], "an empty file"),
}


@pytest.mark.parametrize("name", SPOILED)
def test_a_bad_plan_is_refused_with_its_line(flown, name):
    problem, _, path, lines = flown
    spoil, told = SPOILED[name]
    path.write_text("\n".join(spoil(lines)))
    with pytest.raises(DataFormatError) as raised:
        read_region_plan(path, problem)
    assert told in str(raised.value)
    assert all(fault.file == str(path) for fault in raised.value.faults)


def test_stages_begin_where_the_searcher_starts(flown):
    problem, plan, *_ = flown
    first, *_ = stages(problem, problem.searcher, plan.actions[0])
    assert (first.kind, first.cell, first.time_s) == ("start", problem.searcher.start, 0.0)
