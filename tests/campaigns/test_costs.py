"""The reckoning of `docs/what_a_campaign_costs.md`, on a ledger that is filled by hand."""

import subprocess
import sys
from pathlib import Path

from sooner.campaigns.study import read_study
from tests.campaigns.filled import filled

ROOT = Path(__file__).parents[2]
STUDY = """
title = "S"
trials = 3
budgets = [1, 2]
[instances]
hills = {}
[planners]
a = {}
b = { most_trials = 1 }
"""


def test_core_hours_and_dollars_are_those_of_a_million_trials(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    filled(read_study(tmp_path), tmp_path, lambda trial: {"value": 1.0}).ledger.close()  # 0.25 CPU s, 0.5 wall s each
    command = [sys.executable, str(ROOT / "benchmarks/campaigns/costs.py"), str(tmp_path / "trials.sqlite")]
    told = subprocess.run([*command, "--price", "0.1"], capture_output=True, text=True, check=True).stdout
    assert "| a | 2 | 6 | 0.25 | 0.5 | 100 | 69 | 7 |" in told
    assert "| b | 2 | 2 | 0.25 * | 0.5 | 100 | 69 | 7 |" in told


def test_the_page_shows_every_planner_of_the_study():
    page = (ROOT / "docs/what_a_campaign_costs.md").read_text(encoding="utf-8")
    for planner in read_study(ROOT / "benchmarks/papers/lin2014").file.planners:
        assert f"| {planner} | " in page
