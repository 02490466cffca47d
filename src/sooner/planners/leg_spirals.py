"""First routes about one home: a spiral with two arms for each sortie, out on the one and back on the other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sooner.planners.leg_ground import LegGround, Route

__all__ = ["spiral_loop", "spiral_routes"]

SAGITTA = 0.05  # of the width: as far as a leg may cut off a bend
LONGEST_TURN = np.pi / 4  # between the corners of an arm
BISECTIONS = 16  # of the angle through which arms wind


def spiral_routes(ground: LegGround, width: float, sense: float) -> list[Route] | None:
    """Round trips that fit the budgets, from one home, that sweep it and what lies about it once; None of many homes.

    Arms wind until a sortie has no time left, or nothing pays as far out. Where ways around walls cost time that was
    not reckoned with, a route turns home earlier.

    Parameters
    ----------
    width : float           metres between arms next to each other
    sense : float           1 winds counter-clockwise, -1 clockwise
    """
    moves = ground.moves
    home = np.array(moves[0].home)
    if any(each.home != moves[0].home or each.end != each.home for each in moves):
        return None
    count = len(moves)
    pays = ground.problem.grid.centres_m[ground.within_reach]
    if len(pays) == 0:
        return None
    low, high = 0.0, (np.hypot(*(pays - home).T).max() / width + 1) * np.pi / count + 2 * np.pi
    for _ in range(BISECTIONS):
        turned = (low + high) / 2
        loops = [home + spiral_loop(number, count, turned, width, sense) for number in range(count)]
        fits = all(ground.seconds(number, loop) <= ground.budgets[number] for number, loop in enumerate(loops))
        low, high = (turned, high) if fits else (low, turned)
    routes = []
    for number in range(count):
        inner = home + spiral_loop(number, count, low, width, sense)[1:-1]
        routes.append(ground.fitting(number, inner[moves[0].airspace.joined(home, inner)])[0])
    return routes


def spiral_loop(number: int, count: int, turned: float, width: float, sense: float = 1.0) -> NDArray[np.float64]:
    """(n, 2) metres about home: out on arm 2 `number` of 2 `count` arms, one arm inwards, and back on that.

    radius = 2 count width angle / (2 pi),   arm k turned by 2 pi k / (2 count)

    So arms next to each other lie `width` apart along any ray, and no ground is swept twice but near home.

    Parameters
    ----------
    turned : float          radians through which the outer arm winds
    """
    arms = 2 * count
    grows = arms * width / (2 * np.pi)
    out = _arm(grows, turned, width)
    back = _arm(grows, max(turned - 2 * np.pi / arms, 0.0), width)
    first = 2 * np.pi * (2 * number) / arms
    return np.concatenate([_places(grows, out, first, sense), _places(grows, back, first + np.pi / count, sense)[::-1]])


def _arm(grows: float, turned: float, width: float) -> NDArray[np.float64]:
    """Angles at the corners of an arm: legs that cut off no more of a bend than they may."""
    angles = [0.0]
    while angles[-1] < turned:
        radius = max(grows * angles[-1], width / 4)
        angles.append(angles[-1] + min(np.sqrt(8 * SAGITTA * width / radius), LONGEST_TURN))
    return np.array([*angles[:-1], turned])


def _places(grows: float, angles: NDArray[np.float64], first: float, sense: float) -> NDArray[np.float64]:
    at = sense * (first + angles)
    return np.stack([grows * angles * np.cos(at), grows * angles * np.sin(at)], axis=-1)
