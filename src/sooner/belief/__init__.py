"""Where the person may be: a belief over cells, how a miss changes it, how it drifts."""

from sooner.belief.belief import Belief
from sooner.belief.update import predict, update_on_miss

__all__ = ["Belief", "predict", "update_on_miss"]
