import contextlib
import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.errors import DataFormatError
from sooner.grid import Grid
from sooner.io import plan_csv, read_plan
from sooner.problem import Plan

GRID = Grid((4, 5))


@given(st.lists(st.lists(st.integers(0, 19), min_size=1, max_size=30), min_size=1, max_size=4))
def test_what_is_written_is_read_back(flights):
    plan = Plan.of(*flights)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plan.csv"
        path.write_bytes(plan_csv(plan, GRID))
        assert read_plan(path, GRID) == plan


@given(st.lists(st.integers(0, 19), min_size=1, max_size=30), st.booleans(), st.sampled_from(["\n", "\r\n"]))
def test_bare_lines_are_one_searcher(cells, header, newline):
    lines = ["row,col"] * header + [f"{cell // 5},{cell % 5}" for cell in cells]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plan.csv"
        path.write_bytes(newline.join(lines).encode())
        assert read_plan(path, GRID) == Plan.of(cells)


@given(st.binary(max_size=200))
def test_anything_else_is_refused_with_a_reason_or_read(content):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plan.csv"
        path.write_bytes(content)
        with contextlib.suppress(DataFormatError):
            assert len(read_plan(path, GRID).actions) >= 1


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("", "an empty file"),
        ("row,col\n", "without steps"),
        ("x,y\n1,2\n", "line 1: 'x,y' came"),
        ("1,2,3\n", "line 1"),
        ("1,2\n1,2,3\n", "line 2"),
        ("0,0\n0,1.5\n", "line 2"),
        ("0,0\n0,9\n", "line 2: cell [0, 9] came; the map has rows 0 to 3 and columns 0 to 4"),
        ("0,0\n-1,0\n", "cell [-1, 0]"),
        ("searcher,step,row,col\n0,0,0,0\n0,2,0,1\n", "line 3: step 2 of searcher 0 came; expected step 1"),
        ("searcher,step,row,col\n0,1,0,0\n", "expected step 0"),
        ("searcher,step,row,col\n1,0,0,0\n", "numbered from 0"),
        ("searcher,step,row,col\n0,0,0,0\n-1,0,0,0\n", "numbered from 0"),
        ("searcher,action,kind,region,row,col,time_s\n0,0,a,1,0,0,0\n", "line 1"),
    ],
)
def test_a_bad_plan_is_refused_with_its_line(tmp_path, content, told):
    (tmp_path / "plan.csv").write_text(content)
    with pytest.raises(DataFormatError) as raised:
        read_plan(tmp_path / "plan.csv", GRID)
    assert told in str(raised.value)


def test_many_wrong_lines_are_counted_rather_than_listed(tmp_path):
    (tmp_path / "plan.csv").write_text("9,9\n" * 500)
    with pytest.raises(DataFormatError, match="490 more lines are wrong") as raised:
        read_plan(tmp_path / "plan.csv", GRID)
    assert len(raised.value.faults) == 11
