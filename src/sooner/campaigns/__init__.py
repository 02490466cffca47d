"""Thousands of trials that survive anything: studies, their ledger, and who flies them."""

from sooner.campaigns.campaign import Progress
from sooner.campaigns.run import Ran, run_study
from sooner.campaigns.study import Study, read_study
from sooner.campaigns.trial import Case, Limits, Outcome, Place, Trial

__all__ = ["Case", "Limits", "Outcome", "Place", "Progress", "Ran", "Study", "Trial", "read_study", "run_study"]
