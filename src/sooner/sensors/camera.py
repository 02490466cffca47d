"""A downward camera: what it sees from an altitude, and how fast it may fly and still see it [Kuhlman2017]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError

__all__ = ["Camera", "speed_to_steer", "speed_to_stop", "steering_distance", "stopping_distance"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Camera:
    """A camera that looks straight down with a global shutter.

    Along the direction of motion it has `pixels` pixels and sees `field_of_view`. Image features that move a pixel or
    more while the shutter is open are blurred: delta_p >= 1.

    Parameters
    ----------
    field_of_view : float        full angle, radians, in (0, pi)
    pixels : int                 N_p along the direction of motion
    exposure : float             t_exp, seconds
    attitude_rate : float        omega_max, rad/s: the fastest turn of the camera in manoeuvres and gusts

    Raises
    ------
    InvalidProblemError          if an angle, a number of pixels or a time makes no sense

    Examples
    --------
    The paper's camera, 90 degrees across its 1200 pixels and open for 2 ms, is blurred at 10 m/s and 10 m:

    >>> camera = Camera(np.pi / 2, pixels=1200, exposure=2e-3)
    >>> float(camera.blur(speed=10.0, altitude=10.0).round(3)), float(camera.footprint_radius(8.8).round(3))
    (1.8, 8.8)
    """

    field_of_view: float
    pixels: int
    exposure: float
    attitude_rate: float = 0.5

    def __post_init__(self) -> None:
        if not 0.0 < self.field_of_view < np.pi:
            raise InvalidProblemError(f"field of view {self.field_of_view} came; expected radians between 0 and pi")
        if self.pixels < 1:
            raise InvalidProblemError(f"{self.pixels} pixels came; expected at least 1")
        if not 0.0 < self.exposure < np.inf:
            raise InvalidProblemError(f"exposure {self.exposure} came; expected seconds above 0")
        if not 0.0 <= self.attitude_rate < np.inf:
            raise InvalidProblemError(f"attitude rate {self.attitude_rate} came; expected rad/s of at least 0")

    def footprint_radius(self, altitude: ArrayLike) -> Floats:
        """Radius in metres of the ground in view, r_z tan(fov / 2): 90 degrees see as far as they are high."""
        return np.asarray(_positive(altitude, "altitude") * np.tan(self.field_of_view / 2.0))

    def ground_speed(self, speed: ArrayLike, altitude: ArrayLike) -> Floats:
        """Largest speed of the ground in the image plane, m/s: v_g = |v| + r_z |omega|   [Kuhlman2017, section 6.3]."""
        return np.abs(speed) + _positive(altitude, "altitude") * self.attitude_rate

    def blur(self, speed: ArrayLike, altitude: ArrayLike) -> Floats:
        """Motion of the image while the shutter is open, in pixels; from 1 on it is blurred.

        delta_p = v_g t_exp N_p / FOV,  FOV = 2 r_z tan(fov / 2) metres                  [Kuhlman2017, eq. (16)]

        Notes
        -----
        The paper's first example, (10 m/s, 10 m, 2 ms), gives its 1.8 pixels with N_p = 1200, the short side. Its
        second gives 5.4 for (20 m/s, 5 m) as printed, outside its own envelope; the 0.9 is that of (5 m/s, 20 m).
        """
        return self.ground_speed(speed, altitude) * self._pixels_per_metre_second(altitude)

    def largest_speed(self, altitude: ArrayLike, blur: float = 1.0) -> Floats:
        """Speed in m/s at which the image moves `blur` pixels; slower is sharp. 0 where turning alone blurs it.

        v = r_z (2 tan(fov / 2) blur / (t_exp N_p) - omega): with twice the altitude, twice the speed.

        >>> Camera(np.pi / 2, 1200, 1e-3).largest_speed([5.0, 8.8, 20.0]).round(2)
        array([ 5.83, 10.27, 23.33])
        """
        return _positive(altitude, "altitude") * max(self._speed_per_metre(blur), 0.0)

    def lowest_altitude(self, speed: ArrayLike, blur: float = 1.0) -> Floats:
        """Altitude in metres above which a speed is sharp; inf where turning alone blurs the image.

        >>> float(Camera(np.pi / 2, 1200, 1e-3).lowest_altitude(10.0).round(2))
        8.57
        """
        rate = self._speed_per_metre(blur)
        return np.abs(np.asarray(speed, np.float64)) / rate if rate > 0 else np.full(np.shape(speed), np.inf)

    def _pixels_per_metre_second(self, altitude: ArrayLike) -> Floats:
        return self.exposure * self.pixels / (2.0 * self.footprint_radius(altitude))

    def _speed_per_metre(self, blur: float) -> float:
        return float(2.0 * np.tan(self.field_of_view / 2.0) * blur / (self.exposure * self.pixels) - self.attitude_rate)


def stopping_distance(speed: ArrayLike, acceleration: float) -> Floats:
    """Metres until a vehicle stands: d_stop = v^2 / (2 a)                              [Kuhlman2017, section 5.2]."""
    return np.asarray(np.square(speed) / (2.0 * _positive(acceleration, "acceleration")))


def speed_to_stop(sensing_range: ArrayLike, acceleration: float) -> Floats:
    """Largest speed, m/s, that stops within the range of the obstacle sensor: v = sqrt(2 a d).

    >>> float(speed_to_stop(25.0, acceleration=2.0))
    10.0
    """
    return np.sqrt(2.0 * _positive(acceleration, "acceleration") * _positive(sensing_range, "sensing range"))


def steering_distance(speed: ArrayLike, obstacle: ArrayLike, acceleration: float, *, printed: bool = False) -> Floats:
    """Metres that a vehicle gets aside, its forward speed kept, before it is level with an obstacle ahead.

    d_steer = a d_obs^2 / (2 v^2)
    printed:  d_steer = a d_obs^2 / v^2                                                 [Kuhlman2017, section 5.2]

    Parameters
    ----------
    speed, obstacle : float  v in m/s; d_obs, metres to the obstacle
    acceleration : float     a, m/s^2, all of it sideways
    printed : bool           the equation as it stands in the paper

    Notes
    -----
    The way at constant acceleration during t = d_obs / v is a t^2 / 2; the printed equation lacks the half and so
    promises twice the room. The paper's summary, that twice the speed needs four times the acceleration or range,
    holds for stopping; to steer, twice the range is enough.

    Examples
    --------
    >>> float(steering_distance(10.0, 20.0, acceleration=2.0))
    4.0
    """
    ahead = np.square(_positive(obstacle, "distance to the obstacle") / _positive(speed, "speed"))
    return np.asarray(_positive(acceleration, "acceleration") * ahead / (1.0 if printed else 2.0))


def speed_to_steer(sensing_range: ArrayLike, aside: ArrayLike, acceleration: float) -> Floats:
    """Largest speed, m/s, that gets `aside` metres aside within the range of the sensor: v = d sqrt(a / (2 w)).

    >>> float(speed_to_steer(20.0, aside=4.0, acceleration=2.0))
    10.0
    """
    reach = _positive(sensing_range, "sensing range")
    return reach * np.sqrt(_positive(acceleration, "acceleration") / (2.0 * _positive(aside, "way aside")))


def _positive(values: ArrayLike, name: str) -> Floats:
    checked = np.asarray(values, np.float64)
    if not ((checked > 0) & np.isfinite(checked)).all():
        raise InvalidProblemError(f"{name} came not above 0 or not finite")
    return checked
