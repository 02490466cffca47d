"""An autopilot of small steps: what a .plan of QGroundControl takes to fly, by the file and the aircraft's limits only.

A point mass in three dimensions goes from waypoint to waypoint as copters' autopilots do: straight at the speed that
the file asks for, as far as wind and climb let it; it brakes to a stop where the line turns or is held, and flies on
through waypoints that lie straight ahead. Nothing of `sooner` is used.
"""

import json
import math
from dataclasses import dataclass, field
from itertools import pairwise

STEP_S = 0.02
TURN_RAD = math.radians(0.1)  # a turn below this is straight ahead
SAME_M = 0.01  # between places that are one
PULL = 1.0  # per second, back to the line
TAKEOFF, WAYPOINT, LOITER, RETURN, LAND, SPEED = 22, 16, 17, 20, 21, 178


@dataclass(frozen=True)
class Limits:
    """What the aircraft can do, which its file does not say."""

    accel: float
    climb: float
    descent: float
    airspeed: float = math.inf
    wind: tuple[float, float] = (0.0, 0.0)  # east and north, where it blows to
    landing: tuple[float, float] = (math.inf, 0.0)  # metres a second of the last metres down


@dataclass
class Flown:
    """What happened: seconds between waypoints and in all, and the extremes of the way."""

    between_s: float = 0.0  # from arriving at the first waypoint to leaving the last
    whole_s: float = 0.0  # from the ground to the ground, or to where it circles
    metres: float = 0.0
    top: dict = field(default_factory=lambda: dict.fromkeys(("speed", "accel", "climb", "descent", "air", "off"), 0.0))


@dataclass
class _Drone:
    """A point mass: where it is, how it moves, and what it has done so far."""

    limits: Limits
    place: list
    told: Flown
    velocity: list = field(default_factory=lambda: [0.0, 0.0, 0.0])

    def fly(self, line):
        """Along places (x, y, z, speed) that lie straight ahead of each other, from where it is, to a stop."""
        line = [(*self.place, 0.0), *line]
        legs = [(a, b) for a, b in pairwise(line) if math.dist(a[:3], b[:3]) > SAME_M]
        if not legs:
            return
        lengths = [_length(a, b) for a, b in legs]
        caps = [self._most(a, b, b[3]) for a, b in legs]
        begins = [sum(lengths[:k]) for k in range(len(legs))]
        flown, leg, whole = 0.0, 0, sum(lengths)
        while True:
            while leg + 1 < len(legs) and flown >= begins[leg + 1]:
                leg += 1
            now = self._along(*legs[leg])
            ahead = now * STEP_S
            if whole - flown <= max(ahead, 1e-3) and now <= 2 * self.limits.accel * STEP_S:
                break
            wanted = self._brake(now, flown + ahead, leg, begins, caps, whole)
            self._step(*legs[leg], wanted, flown - begins[leg])
            flown = begins[leg] + self._progress(*legs[leg])
        self.place, self.velocity = list(line[-1][:3]), [0.0, 0.0, 0.0]

    def wait(self, seconds):
        self.told.whole_s += seconds

    def _most(self, a, b, speed):
        """Speed along a leg that the wish, the air, the climb and the descent allow."""
        flat, rise = math.hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2]
        vertical = self.limits.climb if rise > 0 else self.limits.descent
        if flat <= SAME_M:
            return vertical
        if rise:
            speed = min(speed, vertical * flat / abs(rise))
        east, north = (b[0] - a[0]) / flat, (b[1] - a[1]) / flat
        low, high = 0.0, speed
        if self._air(0.0, 0.0) >= self.limits.airspeed:
            raise ValueError("it cannot hold its place in this wind")
        if self._air(high * east, high * north) > self.limits.airspeed:
            for _ in range(60):
                middle = (low + high) / 2
                if self._air(middle * east, middle * north) > self.limits.airspeed:
                    high = middle
                else:
                    low = middle
            return low
        return speed

    def _air(self, east, north):
        return math.hypot(east - self.limits.wind[0], north - self.limits.wind[1])

    def _brake(self, now, flown, leg, begins, caps, whole):
        """Speed from which it still brakes for all that comes: slower legs, and the stop."""
        wanted = caps[leg]
        for k in range(leg + 1, len(caps)):
            room = begins[k] - flown
            if room > now * now / (2 * self.limits.accel) + 1.0:
                break
            wanted = min(wanted, math.sqrt(caps[k] ** 2 + 2 * self.limits.accel * max(room, 0.0)))
        return min(wanted, math.sqrt(2 * self.limits.accel * max(whole - flown, 0.0)) + 1e-3)

    def _along(self, a, b):
        """Its speed along a leg: over the ground, or up and down where the leg is upright."""
        flat = math.hypot(b[0] - a[0], b[1] - a[1])
        if flat <= SAME_M:
            return abs(self.velocity[2])
        return (self.velocity[0] * (b[0] - a[0]) + self.velocity[1] * (b[1] - a[1])) / flat

    def _progress(self, a, b):
        flat = math.hypot(b[0] - a[0], b[1] - a[1])
        if flat <= SAME_M:
            return abs(self.place[2] - a[2])
        return ((self.place[0] - a[0]) * (b[0] - a[0]) + (self.place[1] - a[1]) * (b[1] - a[1])) / flat

    def _step(self, a, b, wanted, done):
        """One small step: speeds up or brakes towards the wanted speed along a leg, and back to its line."""
        flat, rise = math.hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2]
        share = min(max(done / _length(a, b), 0.0), 1.0)
        line = [a[k] + share * (b[k] - a[k]) for k in range(3)]
        if flat <= SAME_M:
            aim = [PULL * (line[0] - self.place[0]), PULL * (line[1] - self.place[1]), math.copysign(wanted, rise)]
        else:
            aim = [(b[k] - a[k]) / flat * wanted + PULL * (line[k] - self.place[k]) for k in range(3)]
        aim[2] = min(max(aim[2], -self.limits.descent), self.limits.climb)
        change = [aim[k] - self.velocity[k] for k in range(3)]
        most = self.limits.accel * STEP_S
        level = math.hypot(change[0], change[1])
        scale = min(1.0, most / level) if level else 1.0
        change = [change[0] * scale, change[1] * scale, min(max(change[2], -most), most)]
        before = list(self.place)
        for k in range(3):
            self.place[k] += (self.velocity[k] + change[k] / 2) * STEP_S
            self.velocity[k] += change[k]
        self._note(change, before, math.dist(self.place, line))

    def _note(self, change, before, off):
        self.told.whole_s += STEP_S
        self.told.metres += math.hypot(self.place[0] - before[0], self.place[1] - before[1])
        seen = {
            "speed": math.hypot(self.velocity[0], self.velocity[1]),
            "accel": max(math.hypot(change[0], change[1]), abs(change[2])) / STEP_S,
            "climb": self.velocity[2],
            "descent": -self.velocity[2],
            "air": self._air(self.velocity[0], self.velocity[1]),
            "off": off,
        }
        self.told.top = {name: max(most, seen[name]) for name, most in self.told.top.items()}


def fly_file(path, limits: Limits) -> Flown:
    """Fly a .plan."""
    mission = json.loads(path.read_text(encoding="utf-8"))["mission"]
    home = mission["plannedHomePosition"]
    speed, told = mission["hoverSpeed"], Flown()
    drone = _Drone(limits, [0.0, 0.0, 0.0], told)
    waypoints, run, first_s = 0, [], None

    items = mission["items"]
    for number, item in enumerate(items):
        command, params = item["command"], item["params"]
        if command == SPEED:
            speed = params[1]
        elif command == TAKEOFF:
            drone.fly([(0.0, 0.0, params[6], speed)])
        elif command == WAYPOINT:
            assert item["frame"] == 3
            run.append((*_east_north(home, params), params[6], speed))
            waypoints += 1
            onward = _next_waypoint(items, number)
            straight = waypoints > 1 and onward is not None and not params[0]
            before = run[-2] if len(run) > 1 else tuple(drone.place)
            if not straight or _turn(before, run[-1], (*_east_north(home, onward), 0.0)) > TURN_RAD:
                drone.fly(run)
                run = []
            if waypoints == 1:
                first_s = told.whole_s
            drone.wait(params[0] or 0.0)
            told.between_s = told.whole_s - first_s
        elif command in (RETURN, LAND):
            there = (0.0, 0.0) if command == RETURN else _east_north(home, params)
            drone.fly([(*there, drone.place[2], speed)])
            _land(drone, there)
        else:
            assert command == LOITER
    return told


def _land(drone, there):
    """Straight down, slowly at last."""
    slow, below = drone.limits.landing
    drone.fly([(*there, min(below, drone.place[2]), math.inf)])
    if drone.place[2] > 0:
        fast, drone.limits = drone.limits, Limits(drone.limits.accel, drone.limits.climb, slow)
        drone.fly([(*there, 0.0, math.inf)])
        drone.limits = fast


def _next_waypoint(items, number):
    """Where it is sent next; speeds may be set on the way."""
    following = next((item for item in items[number + 1 :] if item["command"] != SPEED), None)
    return following["params"] if following is not None and following["command"] == WAYPOINT else None


def _length(a, b):
    flat = math.hypot(b[0] - a[0], b[1] - a[1])
    return flat if flat > SAME_M else abs(b[2] - a[2])


def _turn(a, b, c):
    """Angle at b over the ground; a place twice is a turn."""
    if math.dist(a[:2], b[:2]) <= SAME_M or math.dist(b[:2], c[:2]) <= SAME_M:
        return math.pi
    angle = math.atan2(c[1] - b[1], c[0] - b[0]) - math.atan2(b[1] - a[1], b[0] - a[0])
    return abs(math.remainder(angle, 2 * math.pi))


def _east_north(home, params):
    """Metres east and north of home on the plane that touches the WGS 84 ellipsoid there."""
    lat, lon = math.radians(home[0]), math.radians(home[1])
    dx, dy, dz = (b - a for a, b in zip(_geocentric(*home[:2]), _geocentric(*params[4:6]), strict=True))
    east = -math.sin(lon) * dx + math.cos(lon) * dy
    north = -math.sin(lat) * (math.cos(lon) * dx + math.sin(lon) * dy) + math.cos(lat) * dz
    return east, north


def _geocentric(lat, lon):
    lat, lon = math.radians(lat), math.radians(lon)
    a, e2 = 6_378_137.0, 0.00669437999014
    n = a / math.sqrt(1 - e2 * math.sin(lat) ** 2)
    return (
        n * math.cos(lat) * math.cos(lon),
        n * math.cos(lat) * math.sin(lon),
        n * (1 - e2) * math.sin(lat),
    )
