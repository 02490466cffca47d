"""How people move: transition kernels over cells."""

from sooner.motion.drift import drift_transition

__all__ = ["drift_transition"]
