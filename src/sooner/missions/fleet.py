"""The drones of a mission along legs: vehicles, heights, how far they see, and a sortie for each battery."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from sooner.errors import DataFormatError
from sooner.missions.faults import Faults
from sooner.missions.over_regions import camera_sight
from sooner.missions.settings import Settings
from sooner.missions.vehicles import Vehicle, read_vehicle
from sooner.missions.winds import wind_fault
from sooner.motion.pace import Pace, Terrain
from sooner.motion.wind import Wind

__all__ = ["USUAL_M", "Fleet", "Sortie"]

USUAL_M = 60.0  # above the ground, where neither the drone nor the camera has an altitude
SHORTEST_S = 10.0  # of a sortie that is worth taking off for


@dataclass(frozen=True)
class Sortie:
    """One flight on one battery.

    Parameters
    ----------
    drone : int                 number of its `[[searcher]]`
    battery : int               which of the drone's, from 0
    altitude_m : float          above the ground
    takeoff_s, landing_s : float   before the first leg and after the last
    vehicle : Vehicle or None   where the mission names its file
    """

    drone: int
    battery: int
    altitude_m: float
    takeoff_s: float = 0.0
    landing_s: float = 0.0
    vehicle: Vehicle | None = None


class Fleet:
    """What the file says of its drones, checked; what is wrong is added to the faults."""

    def __init__(self, faults: Faults, settings: Settings) -> None:
        self.faults, self.settings = faults, settings
        self.notes: tuple[str, ...] = ()
        numbers = range(len(settings.searcher))
        self.vehicles = [self._vehicle(number) for number in numbers]
        self.altitudes = [self._altitude(number) for number in numbers]

    def _vehicle(self, number: int) -> Vehicle | None:
        said, key = self.settings.searcher[number], f"searcher[{number}]"
        if said.vehicle is None:
            for name, unit in (("speed_mps", "metres a second"), ("accel_mps2", "metres a second squared")):
                if getattr(said, name) is None:
                    expected = f"expected {unit}, or a vehicle file: along legs flights are timed"
                    self.faults.add(f"{key}.{name}", "nothing came", expected)
            if said.batteries > 1:
                expected = "expected a vehicle file, which says how long one lasts"
                self.faults.add(f"{key}.batteries", f"{said.batteries} came without a vehicle", expected)
            if said.kind == "fixed_wing":
                self.faults.add(
                    f"{key}.kind", "a fixed wing along legs came", "expected 'copter': it stops where it turns"
                )
            if self.settings.wind is not None:
                expected = "expected a vehicle file that says airspeed_mps, or no wind"
                self.faults.add(f"{key}.vehicle", "nothing came beside a wind", expected)
            return None
        try:
            vehicle = read_vehicle(self.faults.path.parent / said.vehicle)
        except DataFormatError as error:
            for fault in error.faults:
                where = f", {fault.key}" if fault.key else ""
                self.faults.add(f"{key}.vehicle", f"{fault.file}{where}: {fault.came}", fault.expected)
            return None
        if vehicle.kind == "fixed_wing":
            self.faults.add(f"{key}.vehicle", "a fixed wing came", "expected a copter: legs stop where they turn")
        windy = wind_fault(str(self.faults.path), self.settings.wind, said.vehicle, vehicle.airspeed_mps)
        if windy is not None:
            self.faults.once(windy.key, windy.came, windy.expected)
        return vehicle

    def _altitude(self, number: int) -> float:
        """Above the ground: what the drone is told, else what the camera needs."""
        said, camera = self.settings.searcher[number].altitude_m, self.settings.sensor.camera
        if said is not None:
            return said
        if camera is not None and camera.altitude_m is not None:
            return camera.altitude_m
        note = f"nobody says how high: flown {USUAL_M:g} m above the ground"
        self.notes += (note,) if note not in self.notes else ()
        return USUAL_M

    def reach_m(self) -> float | None:
        """How far looks reach, whichever way the file says it; None where nobody does."""
        sensor = self.settings.sensor
        told: list[tuple[str, float]] = []
        if sensor.radius_m is not None:
            told.append(("sensor.radius_m", sensor.radius_m))
        if sensor.camera is not None:
            seen, _ = camera_sight(self.faults, sensor.camera)
            told += [] if seen is None else [("sensor.camera", seen)]
        if len(told) > 1:
            self.faults.add("sensor", "radius_m and camera came", "expected one of them")
        if not told and sensor.sweep_width_m is None:
            for number, vehicle in enumerate(self.vehicles):
                seen = None if vehicle is None else vehicle.radius_m(self.altitudes[number])
                if seen is not None:
                    told.append((f"searcher[{number}].vehicle", seen))
            for number, vehicle in enumerate(self.vehicles if told else ()):
                name = self.settings.searcher[number].vehicle
                if (vehicle is None and name is None) or (vehicle is not None and vehicle.camera is None):
                    came = "a drone without a vehicle file" if name is None else f"{name} without [camera]"
                    expected = "expected a camera in every drone's vehicle file, or sensor.radius_m"
                    self.faults.add(f"searcher[{number}].vehicle", f"{came} came beside one that has it", expected)
            if len({radius for _, radius in told}) > 1:
                came = ", ".join(f"{radius:.4g} m by {key}" for key, radius in told)
                self.faults.add(
                    "sensor.radius_m", f"cameras that see {came} came", "expected one radius for all drones"
                )
        if not told and sensor.sweep_width_m is None and not self.faults.among("sensor"):
            expected = "expected metres, a camera, or sweep_width_m: along legs the ground so near is looked at"
            self.faults.add("sensor.radius_m", "nothing came", expected)
        return told[0][1] if told else None

    def pace(self, number: int, wind: Wind, terrain: Terrain | None) -> Pace:
        """How one drone flies legs: no faster than its pictures are sharp."""
        said, vehicle = self.settings.searcher[number], self.vehicles[number]
        sharp = inf
        if self.settings.sensor.camera is not None:
            _, sharp = camera_sight(self.faults, self.settings.sensor.camera)
        if vehicle is None:
            assert said.speed_mps is not None
            assert said.accel_mps2 is not None
            return Pace(min(said.speed_mps, sharp), said.accel_mps2)
        pace = vehicle.pace(self.altitudes[number], wind, terrain)
        asked = min(pace.speed_mps, said.speed_mps or inf, sharp)
        limits = pace.airspeed_mps, pace.wind, pace.climb_mps, pace.descent_mps, pace.terrain
        return Pace(asked, said.accel_mps2 or pace.accel_mps2, *limits)

    def flights(self, number: int, above_m: tuple[float, float]) -> list[tuple[Sortie, float, float]]:
        """Every sortie of one drone with its seconds on legs, and when the first of them begins.

        above_m : by how much the surface that is followed is higher than the ground at its start and its end
        """
        said, vehicle = self.settings.searcher[number], self.vehicles[number]
        altitude, whole = self.altitudes[number], self.settings.budget.seconds
        if vehicle is None:
            if whole is None:
                expected = "expected seconds, or a vehicle file that says how long a battery lasts"
                self.faults.add("budget.seconds", "nothing came", expected)
                return []
            return [(Sortie(number, 0, altitude), whole, 0.0)]
        up, down = vehicle.climb_s(altitude + above_m[0]), vehicle.landing_s(altitude + above_m[1])
        lasts = vehicle.endurance_s - vehicle.reserve_s - up - down
        if lasts < SHORTEST_S:
            came = (
                f"{said.vehicle} has {max(lasts, 0.0):.0f} s left of a battery after its reserve, climbing and landing"
            )
            self.faults.add(f"searcher[{number}].vehicle", came, "expected a longer endurance or a lower altitude_m")
            return []
        found, begins = [], 0.0
        for battery in range(said.batteries):
            left = inf if whole is None else whole - begins - up - down
            if left < SHORTEST_S:
                break
            found.append((Sortie(number, battery, altitude, up, down, vehicle), min(lasts, left), begins + up))
            begins += up + lasts + down + vehicle.swap_s
        if len(found) < said.batteries:
            self.notes += (
                f"drone {number}: {len(found)} of {said.batteries} batteries are flown: budget.seconds ends then",
            )
        if not found:
            came = f"{whole:g} s came, and {said.vehicle} takes {up + down:.0f} s to climb and land"
            self.faults.once("budget.seconds", came, "expected more time")
        return found
