"""The question, the answer and the judge."""

from sooner.problem.evaluate import Evaluation, evaluate
from sooner.problem.gains import Gains, detection_gains
from sooner.problem.incumbent import Incumbent
from sooner.problem.information_gains import evidence_detection_gains, glimpse_information_gains, information_gains
from sooner.problem.moves import CellMoves, Looks, Moves
from sooner.problem.plan import Plan
from sooner.problem.reach import Reach
from sooner.problem.remainder import joined, remainder
from sooner.problem.search_problem import Drift, Objective, Searcher, SearchProblem
from sooner.problem.teleport import Teleport, teleport

__all__ = [
    "CellMoves",
    "Drift",
    "Evaluation",
    "Gains",
    "Incumbent",
    "Looks",
    "Moves",
    "Objective",
    "Plan",
    "Reach",
    "SearchProblem",
    "Searcher",
    "Teleport",
    "detection_gains",
    "evaluate",
    "evidence_detection_gains",
    "glimpse_information_gains",
    "information_gains",
    "joined",
    "remainder",
    "teleport",
]
