"""A study of trials that a test can predict, in a folder of its own."""

import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path

import pytest

WORK = Path(__file__).with_name("work.py")


def small_study(
    tmp_path: Path, planners: str = "a = {}\nb = {}", trials: int = 5, limits: str = "", title: str = "Small"
) -> Path:
    """The folder of a study of `work.py`; planners and limits in TOML."""
    folder = tmp_path / "study"
    folder.mkdir(exist_ok=True)
    shutil.copy(WORK, folder)
    (folder / "study.toml").write_text(
        f'title = "{title}"\ntrial = "work:fly"\ntrials = {trials}\n[limits]\n{limits}\n'
        f"[instances]\nhere = {{}}\n[planners]\n{planners}\n"
    )
    return folder


def ledger_told(folder: Path, query: str) -> list[tuple]:
    """What the ledger in a folder holds."""
    with closing(sqlite3.connect(folder / "trials.sqlite", timeout=30.0)) as base:
        return base.execute(query).fetchall()


@pytest.fixture
def study(tmp_path: Path) -> Callable[..., Path]:
    return partial(small_study, tmp_path)


@pytest.fixture
def told() -> Callable[..., list[tuple]]:
    return ledger_told
