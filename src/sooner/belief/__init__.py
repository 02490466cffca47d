"""Where the person may be: a belief over cells, evidence of each cell by itself, and what looks teach of both."""

from sooner.belief.belief import Belief
from sooner.belief.cell_states import CellStates, odds_of_confidence
from sooner.belief.effort import effort_by_looks, expected_effort, expected_search_time, search_time_limit
from sooner.belief.evidence import BetaGrid, EvidenceGrid, binary_entropy, stationary_theta, theta_from_counts
from sooner.belief.information import (
    beta_information,
    beta_information_table,
    information,
    information_table,
    look_information,
)
from sooner.belief.state_information import InformationTable, state_entropy, state_information
from sooner.belief.street_continuation import StreetContinuation, StreetModel
from sooner.belief.street_kriging import KrigingSession, StreetKriging, street_directions
from sooner.belief.track_before_detect import Track, TrackBeforeDetect
from sooner.belief.tracks import Following, Tracks
from sooner.belief.update import predict, update_on_miss

__all__ = [
    "Belief",
    "BetaGrid",
    "CellStates",
    "EvidenceGrid",
    "Following",
    "InformationTable",
    "KrigingSession",
    "StreetContinuation",
    "StreetKriging",
    "StreetModel",
    "Track",
    "TrackBeforeDetect",
    "Tracks",
    "beta_information",
    "beta_information_table",
    "binary_entropy",
    "effort_by_looks",
    "expected_effort",
    "expected_search_time",
    "information",
    "information_table",
    "look_information",
    "odds_of_confidence",
    "predict",
    "search_time_limit",
    "state_entropy",
    "state_information",
    "stationary_theta",
    "street_directions",
    "theta_from_counts",
    "update_on_miss",
]
