"""Compiled flight of agents: a double integrator under a proportional-derivative law, saturated and damped.

With place p, velocity v and waypoint w,

    u = sat(k_p (w - p) - k_d v, a_max),   v' = u - (a_max / v_max) v,   p' = v         [Wolek2020, section II.C]

by Euler's rule. What the agent thrusts with, u, is never longer than a_max; its speed never passes v_max; so while it
brakes, thrust and damping together slow it by at most 2 a_max. Helpers that kernels share return numbers, no arrays.
"""

import math

from numba import njit

K_P = 10.0  # 1/s^2
K_D = 5.0  # 1/s
STEP_S = 0.02


@njit(cache=True, nogil=True, inline="always")
def thrust(ex, ey, vx, vy, a_max):
    """Thrust towards a waypoint (ex, ey) away: (east, north), never longer than a_max."""
    ux = K_P * ex - K_D * vx
    uy = K_P * ey - K_D * vy
    square = ux * ux + uy * uy
    if square > a_max * a_max:
        scale = a_max / math.sqrt(square)
        ux *= scale
        uy *= scale
    return ux, uy


@njit(cache=True, nogil=True)
def fly(places, velocities, v_max, a_max, capture_m, routes, lengths, reached, seconds, step_s):
    """Every agent flies its route for a while; a waypoint nearer than `capture_m` gives way to the next one.

    places, velocities : (A, 2)    changed in place
    v_max, a_max, capture_m : (A,)
    routes : (A, K, 2)             waypoints; the first `lengths[a]` count. At the last an agent hovers
    reached : (A,) int64           waypoints of the route left behind; changed in place
    """
    n_steps = round(seconds / step_s)
    for agent in range(places.shape[0]):
        px, py = places[agent, 0], places[agent, 1]
        vx, vy = velocities[agent, 0], velocities[agent, 1]
        damping = a_max[agent] / v_max[agent]
        near = capture_m[agent] * capture_m[agent]
        length, leg = lengths[agent], reached[agent]
        for _ in range(n_steps):
            ux, uy = 0.0, 0.0
            if length > 0:
                aim = min(leg, length - 1)
                ex, ey = routes[agent, aim, 0] - px, routes[agent, aim, 1] - py
                while leg < length and ex * ex + ey * ey <= near:
                    leg += 1
                    aim = min(leg, length - 1)
                    ex, ey = routes[agent, aim, 0] - px, routes[agent, aim, 1] - py
                ux, uy = thrust(ex, ey, vx, vy, a_max[agent])
            px += step_s * vx
            py += step_s * vy
            vx += step_s * (ux - damping * vx)
            vy += step_s * (uy - damping * vy)
        places[agent, 0], places[agent, 1] = px, py
        velocities[agent, 0], velocities[agent, 1] = vx, vy
        reached[agent] = leg


@njit(cache=True, nogil=True)
def fly_to(px, py, vx, vy, wx, wy, v_max, a_max, arrive_m, most_s, step_s, sample_s, trace):
    """One agent flies to one waypoint, until it is within `arrive_m` or `most_s` have passed.

    trace : (K, 2)    filled with the places after each `sample_s`, and with the place of arrival after the last of
                      them, as far as there is room

    Returns (seconds, places in the trace, place east, north, velocity east, north).
    """
    damping = a_max / v_max
    near = arrive_m * arrive_m
    every = max(round(sample_s / step_s), 1)
    most_steps = round(most_s / step_s)
    steps = 0
    seen = 0
    while steps < most_steps:
        ex, ey = wx - px, wy - py
        if ex * ex + ey * ey <= near:
            break
        ux, uy = thrust(ex, ey, vx, vy, a_max)
        px += step_s * vx
        py += step_s * vy
        vx += step_s * (ux - damping * vx)
        vy += step_s * (uy - damping * vy)
        steps += 1
        if steps % every == 0 and seen < trace.shape[0]:
            trace[seen, 0], trace[seen, 1] = px, py
            seen += 1
    if (steps % every != 0 or steps == 0) and seen < trace.shape[0]:
        trace[seen, 0], trace[seen, 1] = px, py
        seen += 1
    return steps * step_s, seen, px, py, vx, vy
