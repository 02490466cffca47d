"""A campaign that has been flown, without a flight: its ledger is filled by hand."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sooner.campaigns.campaign import Progress
from sooner.campaigns.ledger import ASIDE, DONE, Ledger
from sooner.campaigns.run import LEDGER, Ran
from sooner.campaigns.study import Study
from sooner.campaigns.trial import Outcome, Trial

MADE_BY = {
    "commit": "abc", "source": "s", "data": "d", "python": "3", "packages": {"numpy": "2"}, "processor": "a processor"
}  # fmt: skip


def filled(study: Study, folder: Path, answer: Callable[[Trial], dict[str, Any] | None]) -> Ran:
    """Every trial of the study with its answer; None sets it aside."""
    asked = study.asked()
    folder.mkdir(parents=True, exist_ok=True)
    ledger = Ledger(folder / LEDGER, study.key)
    trials = [Trial(case, seed) for case, seeds in asked.cases for seed in seeds]
    ledger.write([], trials)
    ended = []
    for trial in trials:
        said = answer(trial)
        made, took = json.dumps(MADE_BY), (0.5, 0.25, 100.0)
        if said is None:
            ended.append((Outcome(trial, "error", "", "Boom: it broke", *took, made), ASIDE))
        else:
            ended.append((Outcome(trial, "done", json.dumps(said), "", *took, made), DONE))
    ledger.write(ended, [])
    aside = sum(state == ASIDE for _, state in ended)
    return Ran(asked, ledger, Progress(len(trials), len(trials) - aside, aside, 1.0, None))
