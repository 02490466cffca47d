"""Papers run again: many seeds, many planners, intervals, and what was printed beside what came out."""

from sooner.experiments.reproduce import Reproduction, reproduce

__all__ = ["Reproduction", "reproduce"]
