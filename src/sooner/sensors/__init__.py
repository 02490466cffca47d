"""What a look can see: glimpse probability, and how repeated looks add up."""

from sooner.sensors.glimpse import glimpse_from_difficulty, miss_after_looks

__all__ = ["glimpse_from_difficulty", "miss_after_looks"]
