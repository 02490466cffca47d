"""What a look can see: glimpse probability, false alarms, the camera, and how repeated looks add up."""

from sooner.sensors.binary import BinarySensor
from sooner.sensors.camera import Camera, speed_to_steer, speed_to_stop, steering_distance, stopping_distance
from sooner.sensors.footprint import cell_passes, swept_cells
from sooner.sensors.glimpse import glimpse_from_difficulty, miss_after_looks
from sooner.sensors.graded import GradedSensor

__all__ = [
    "BinarySensor",
    "Camera",
    "GradedSensor",
    "cell_passes",
    "glimpse_from_difficulty",
    "miss_after_looks",
    "speed_to_steer",
    "speed_to_stop",
    "steering_distance",
    "stopping_distance",
    "swept_cells",
]
