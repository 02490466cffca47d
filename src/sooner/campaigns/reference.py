"""The reference page of the study file, written from what is checked."""

from __future__ import annotations

from textwrap import fill

from sooner.campaigns.study import OfCampaign, OfTrial, Rule, StudyFile, Table
from sooner.io.reference import about, keys_table

__all__ = ["reference_page"]

_EXAMPLE = """\
```toml
title = "Mine against the default"
trials = 20                                       # seeds 0, 1, ... of each case
budgets = [300, 600]

[instances]
hills = { scenario = "many-hills", seed = "trial" }  # another map for each seed
valley = { mission = "valley/mission.toml" }

[planners]
anneal = { name = "anneal", ticks = 200 }
mine = { make = "my_planner:MyPlanner", width = 3, ticks = 200 }
```"""

_TABLES = ("limits", "instances", "planners", "tables", "rules", "paper")

_FLIGHT = """\
What stands in the braces is for the trial that the study names. The one that is flown if it names none,
`sooner.experiments.flight:fly`, plans once and lets the judge say what the plan is worth.

| instance | meaning |
|---|---|
| `mission` | a mission file, relative to the study's folder |
| `scenario` | a name that `sooner scenario` lists; with `seed` another search of its kind, with `size` another size |

`seed = "trial"` draws the scenario from the trial's seed: every seed is another search, the same for all planners.
What the study says then holds for searches of that kind, not for one of them; and comparing planners seed by seed pays,
because both meet the same search. On a mission, or a scenario with a seed of its own, the trial's seed drives the
planner's random numbers alone: two planners share nothing by it, and a planner without random numbers gives the same
plan under every seed.

A budget is the steps of every searcher, in place of those of the mission or scenario.

| planner | meaning |
|---|---|
| `name` | a planner that `sooner planners` lists; several drones and a target are planned as `sooner plan` does |
| `make` | `"module:Class"`: a planner of your own, in a file beside the study, or any class that Python finds |
| `ticks`, `seconds`, `cpu_seconds` | when to stop, one of them; without one it plans until it has finished |
| `proved` | true: prove a bound beside it |

Every other key is a setting of the planner; a setting in braces with `name` or `make` is a planner or object too. Only
`ticks`, and planners that finish, give the same plan everywhere. `cpu_seconds` counts the time of all threads
together, so that other work on the machine does not matter.

Each trial answers `value` (as the objective counts it), `efficiency` (over teleporting), `bound` and `gap` (where
something is proved), `status` (why it stopped), `timing.seconds` and `timing.cpu_seconds`."""

_OWN = """\
## A trial of your own

`trial = "my_trial:fly"` names a function in a file beside the study. It takes a trial and a place, and answers what
JSON can hold; numbers and yes or no become measures, lists are kept in the ledger only.

```python
import numpy as np


def fly(trial, place):
    rng = np.random.default_rng(trial.seed)
    said = trial.instance  # what stands in the instance's braces; so trial.planner, trial.budget
    return {"found": bool(rng.random() < said["chance"]), "timing": {"seconds": 0.1}}
```

It must be a pure function of the two: the same trial gives the same answer in any process, on any machine, in any
order. What depends on the machine stands under `timing`. Names of what a trial is, as `seed` and `planner`, are taken:
an answer of such a name stands in `trials.csv` as `answer.seed`."""


def reference_page() -> str:
    """`docs/study_file.md`, as Markdown."""
    words = {Table: "table", Rule: "table", dict: "table"}
    parts = [
        "# The study file",
        "A study file is TOML: instances x planners x budgets x seeds. `sooner study FILE` flies every trial of it. "
        "Every fault of the file is reported at once, with key, what came and what was expected, before anything is "
        "flown.",
        _EXAMPLE,
        f"## At the top\n\n{keys_table(StudyFile, words, _TABLES)}",
        "The ledger, `trials.sqlite`, keeps a row for each trial. A study may grow: more seeds, budgets, instances or "
        "planners are flown beside those that are there. A planner or instance whose braces change is another case and "
        "is flown anew. Another title is another study.",
        "## `[instances]`, `[planners]`",
        "`name = { ... }`, at least one of each; no `*` or `?` in a name.",
        _FLIGHT,
        "These keys of a planner are for the campaign, whatever the trial:",
        keys_table(OfCampaign, words),
        f"## `[limits]`\n\n{about(OfTrial)}\n\n{keys_table(OfTrial, words)}",
        f"## `[[tables]]`\n\n{about(Table)}\n\n{keys_table(Table, words)}",
        "`sooner study` writes tables to `tables.md` and `tables.csv`; `summary.md` and `trials.csv` hold every "
        "measure of everything that was flown, whether or not a table shows it: [the files of a campaign]"
        "(campaign_files.md). Where several cases share a cell, its interval is by a bootstrap over seeds that keeps "
        "the trials of a seed together.",
        _OWN,
        f"## `[[rules]]`\n\nFor studies of papers, which `sooner reproduce` flies. {about(Rule)}\n\n"
        f"{keys_table(Rule, words)}",
        "## `[paper]`\n\nFor studies of papers. `claims` and `figures` name functions, as `module:function`: what the "
        "paper says in words, counted in ours; and its figures, drawn again if every table that `figures_from` lists "
        "was flown. Other keys are for these functions.",
    ]
    return "\n\n".join(map(_wrapped, parts)) + "\n"


def _wrapped(text: str) -> str:
    """Paragraphs in lines of 120; tables, code and what is wrapped already stay as they are."""
    paragraphs = text.split("\n\n")
    return "\n\n".join(part if "\n" in part else fill(part, 120, break_on_hyphens=False) for part in paragraphs)
