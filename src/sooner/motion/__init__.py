"""How people move, and how drones do: transition kernels over cells, flights with limited acceleration."""

from sooner.motion.drift import drift_transition
from sooner.motion.kinematics import Dynamics, Profile
from sooner.motion.pace import Pace, Terrain
from sooner.motion.rounded import rounded
from sooner.motion.trajectory import Course, Flown, Trajectory, integrated

__all__ = [
    "Course",
    "Dynamics",
    "Flown",
    "Pace",
    "Profile",
    "Terrain",
    "Trajectory",
    "drift_transition",
    "integrated",
    "rounded",
]
