"""Who searches: agents with their flight and their sensors, and where they are when a second has passed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.sensors.graded import GradedSensor

__all__ = ["Agent", "Team", "flight"]

MOST_AGENTS = 1000
FARTHEST_M = 1e6  # that anybody sees: squares of metres stay numbers
STEP_S = 0.02  # of Euler's rule; a hundredth of it moves an agent by less than 5 cm a minute


@dataclass(frozen=True)
class Agent:
    """One drone: how fast it flies, how hard it turns and brakes, how far and how well it sees.

    It is a double integrator under a proportional-derivative law, with saturated thrust and linear damping
    [Wolek2020, section II.C]; both of its sensors look at every cell whose centre is within the radius.

    Parameters
    ----------
    v_max : float                    m/s, never passed
    a_max : float                    m/s^2, never passed by the thrust
    radius_m : float                 how far it sees, at most 1e6
    map_sensor : GradedSensor        has a signal in cells that are not void
    target_sensor : GradedSensor     has a signal where a target is

    Raises
    ------
    InvalidProblemError              if a number is not positive, a radius beyond 1e6 m, or a thrust so large
                                     against the speed that flight cannot be followed in steps of 0.02 s

    Examples
    --------
    >>> Agent().radius_m, Agent(v_max=6.0).a_max
    (12.5, 2.0)
    """

    v_max: float = 3.0
    a_max: float = 2.0
    radius_m: float = 12.5
    map_sensor: GradedSensor = GradedSensor()
    target_sensor: GradedSensor = GradedSensor()

    def __post_init__(self) -> None:
        for name in ("v_max", "a_max", "radius_m"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise InvalidProblemError(f"an agent with {name} = {value} came; expected a positive number")
        if self.radius_m > FARTHEST_M:
            raise InvalidProblemError(
                f"an agent with radius_m = {self.radius_m} came; expected at most {FARTHEST_M:g} m"
            )
        if STEP_S * self.a_max > 0.5 * self.v_max:
            raise InvalidProblemError(
                f"an agent with a_max = {self.a_max} m/s^2 and v_max = {self.v_max} m/s came; expected it to need more "
                f"than {2 * STEP_S} s to its full speed"
            )


@dataclass(frozen=True, eq=False)
class Team:
    """Agents as arrays, as kernels take them.

    Examples
    --------
    >>> Team((Agent(), Agent(v_max=6.0))).v_max
    array([3., 6.])
    """

    agents: tuple[Agent, ...]

    def __post_init__(self) -> None:
        if not 1 <= len(self.agents) <= MOST_AGENTS:
            raise InvalidProblemError(f"{len(self.agents)} agents came; expected 1 to {MOST_AGENTS}")

    @property
    def v_max(self) -> NDArray[np.float64]:
        """(A,) float."""
        return np.array([agent.v_max for agent in self.agents], float)

    @property
    def a_max(self) -> NDArray[np.float64]:
        """(A,) float."""
        return np.array([agent.a_max for agent in self.agents], float)

    @property
    def radius_m(self) -> NDArray[np.float64]:
        """(A,) float."""
        return np.array([agent.radius_m for agent in self.agents], float)


def flight(
    agent: Agent,
    place: ArrayLike,
    route: Sequence[ArrayLike],
    *,
    capture_m: float,
    seconds: float,
    velocity: ArrayLike = (0.0, 0.0),
    sample_s: float = 1.0,
    step_s: float = STEP_S,
) -> NDArray[np.float64]:
    """Where an agent is on its way along a route, at the start and after each `sample_s`.

    Parameters
    ----------
    agent : Agent
    place, velocity : (2,) float     metres and metres a second, east and north
    route : sequence of (2,) float   waypoints; it hovers at the last
    capture_m : float                how near a waypoint it must come before it turns to the next
    seconds : float

    Returns
    -------
    (n, 2) float

    Examples
    --------
    >>> flight(Agent(), [0, 0], [[9, 0]], capture_m=1.0, seconds=8)[[0, 1, 4, 8]].round(1)
    array([[0. , 0. ],
           [0.8, 0. ],
           [7.8, 0. ],
           [9. , 0. ]])
    """
    from sooner.simulation._flight_kernels import fly

    team = Team((agent,))
    places, velocities = np.array([place], float), np.array([velocity], float)
    legs = np.array(route, float).reshape(1, -1, 2)
    reached = np.zeros(1, np.int64)
    seen = [places[0].copy()]
    for _ in range(round(seconds / sample_s)):
        fly(
            places, velocities, team.v_max, team.a_max, np.array([float(capture_m)]), legs,
            np.array([legs.shape[1]], np.int64), reached, float(sample_s), float(step_s),
        )  # fmt: skip
        seen.append(places[0].copy())
    return cast("NDArray[np.float64]", np.array(seen))
