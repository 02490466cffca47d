"""A vehicle file: how an aircraft flies, how long, and what its camera sees; `docs/vehicle_file.md` tells the keys."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, radians
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from sooner.io.flights.aircraft import DJI_MODELS, Aircraft
from sooner.io.reading import read_toml
from sooner.missions.faults import Faults
from sooner.missions.settings import Metres, Name, NotNegative, Positive, Speed
from sooner.motion import Dynamics, Pace, Terrain
from sooner.motion.wind import Wind
from sooner.sensors.camera import Camera

__all__ = ["Vehicle", "VehicleCamera", "VehicleFile", "read_vehicle"]

Seconds = Annotated[float, Field(gt=0, le=1_000_000, allow_inf_nan=False)]
Pause = Annotated[float, Field(ge=0, le=1_000_000, allow_inf_nan=False)]


class _Table(BaseModel):
    # every key has a default, so that a file with faults still shows what else is wrong with it
    model_config = ConfigDict(extra="forbid", frozen=True)


class VehicleCamera(_Table):
    """`[camera]`: a camera that looks straight down; all three keys, or no table.

    From an altitude h, which the mission says, it sees h tan(fov / 2) to each side, and no leg is flown faster than its
    pictures are sharp: while the shutter is open the image moves by less than a pixel, turning at 0.5 rad/s
    [Kuhlman2017, eq. (16)].
    """

    fov_deg: float | None = Field(default=None, gt=0, lt=180, description="full angle of view, degrees")
    pixels: Annotated[int, Field(strict=True, ge=1)] | None = Field(
        default=None, description="along the direction of flight"
    )
    exposure_s: Positive | None = Field(default=None, description="of one picture")


class VehicleFile(_Table):
    """At the top: what a vehicle file may say, key by key."""

    name: Name = Field(default="", description="what the vehicle is called, in one line; left out: the file's name")
    kind: Literal["copter", "fixed_wing"] = Field(
        default="copter", description="a copter may hover; a fixed wing neither hovers nor turns straight back"
    )
    speed_mps: Speed | None = Field(default=None, description="over the ground, asked for between stops; required")
    accel_mps2: Speed | None = Field(default=None, description="the most, speeding up and braking; required")
    airspeed_mps: Speed | None = Field(
        default=None, description="the most through the air, at least `speed_mps`; needed where a mission tells a wind"
    )
    climb_mps: Speed | None = Field(default=None, description="the most upwards; required")
    descent_mps: Speed | None = Field(default=None, description="the most downwards; required")
    endurance_s: Seconds | None = Field(
        default=None, description="of one full battery, from motors on to motors off; required"
    )
    reserve: float | None = Field(
        default=None,
        ge=0,
        lt=1,
        description="share of the endurance that is never planned with; 0 for none, on purpose (this or `reserve_s`)",
    )
    reserve_s: NotNegative | None = Field(default=None, description="the same in seconds (this or `reserve`)")
    swap_s: Pause = Field(default=0.0, description="on the ground from one battery's flight to the next")
    takeoff_s: Pause = Field(default=0.0, description="with motors on before it climbs")
    landing_mps: Speed | None = Field(
        default=None, description="of the last metres down, at most `descent_mps`; left out: `descent_mps`"
    )
    landing_below_m: Metres | None = Field(
        default=None, description="above ground, from where it is `landing_mps`; the two come together"
    )
    autopilot: Literal["ardupilot", "px4"] = Field(
        default="ardupilot", description="for which exported flights are written"
    )
    dji: str | None = Field(
        default=None, description=f"the aircraft for which DJI's files are written: {', '.join(DJI_MODELS)}"
    )
    camera: VehicleCamera | None = Field(default=None, description="a table, as below")


@dataclass(frozen=True)
class Vehicle:
    """An aircraft, as its file describes it; the keys of `VehicleFile`, complete and in SI units.

    Examples
    --------
    >>> drone = Vehicle("example", 10.0, 2.0, climb_mps=4.0, descent_mps=2.0, endurance_s=1500.0, reserve_s=300.0)
    >>> drone.climb_s(60.0), drone.landing_s(60.0), drone.flying_s(60.0)
    (17.0, 31.0, 1152.0)
    >>> drone.pace(altitude_m=60.0).leg_seconds([[0, 0]], [[100, 0]])
    array([15.])
    """

    name: str
    speed_mps: float
    accel_mps2: float
    climb_mps: float
    descent_mps: float
    endurance_s: float
    reserve_s: float
    airspeed_mps: float | None = None
    swap_s: float = 0.0
    takeoff_s: float = 0.0
    landing_mps: float | None = None
    landing_below_m: float = 0.0
    kind: Literal["copter", "fixed_wing"] = "copter"
    autopilot: str = "ardupilot"
    dji: str | None = None
    camera: Camera | None = None

    def climb_s(self, altitude_m: float) -> float:
        """Seconds from motors on to rest at an altitude above the ground."""
        return self.takeoff_s + float(Dynamics(self.climb_mps, self.accel_mps2).leg_seconds(altitude_m))

    def landing_s(self, altitude_m: float) -> float:
        """Seconds from rest at an altitude above the ground to the ground; it slows down before the last metres."""
        slow_m = 0.0 if self.landing_mps is None else min(self.landing_below_m, altitude_m)
        down = float(Dynamics(self.descent_mps, self.accel_mps2).leg_seconds(altitude_m - slow_m))
        return down + slow_m / (self.landing_mps or inf)

    def flying_s(self, altitude_m: float) -> float:
        """Seconds of one battery for the way at an altitude, from above the start to above the landing.

        endurance less reserve less climb less landing; at most 0 where it cannot even do that.
        """
        return self.endurance_s - self.reserve_s - self.climb_s(altitude_m) - self.landing_s(altitude_m)

    def radius_m(self, altitude_m: float) -> float | None:
        """How far to each side its camera sees the ground; None without a camera."""
        return None if self.camera is None else float(self.camera.footprint_radius(altitude_m))

    def cruise_mps(self, altitude_m: float) -> float:
        """Speed asked for over the ground: no faster than the camera's pictures are sharp [Kuhlman2017, eq. (16)]."""
        sharp = inf if self.camera is None else float(self.camera.largest_speed(altitude_m))
        return min(self.speed_mps, sharp)

    def pace(self, altitude_m: float, wind: Wind = (0.0, 0.0), terrain: Terrain | None = None) -> Pace:
        """How it flies legs at an altitude above the ground, in a wind that blows to (east, north), over terrain."""
        limits = self.accel_mps2, self.airspeed_mps, wind, self.climb_mps, self.descent_mps
        return Pace(self.cruise_mps(altitude_m), *limits, terrain)

    @property
    def aircraft(self) -> Aircraft:
        """For which autopilot and DJI model files are written."""
        return Aircraft(self.autopilot) if self.dji is None else Aircraft(self.autopilot, self.dji)


def read_vehicle(path: Path | str) -> Vehicle:
    """Read a vehicle file.

    Raises
    ------
    DataFormatError        with every fault of the file

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "vehicle.toml"
    >>> _ = path.write_text("speed_mps = 12\\naccel_mps2 = 2\\nclimb_mps = 3\\nendurance_s = 1500\\nreserve = 0.2")
    >>> read_vehicle(path)
    Traceback (most recent call last):
    ...
    sooner.errors.DataFormatError: ...vehicle.toml: descent_mps: nothing came; expected metres a second
    """
    path = Path(path)
    faults = Faults(path)
    said = faults.read(read_toml(path, "expected a vehicle file in TOML"), VehicleFile)
    _check_required(faults, said)
    _check_speeds(faults, said)
    reserve_s = _reserve_s(faults, said)
    _check_dji(faults, said)
    camera = _camera(faults, said.camera)
    faults.refuse()
    kept: dict[str, Any] = {
        key: getattr(said, key) for key in VehicleFile.model_fields if key not in ("reserve", "reserve_s", "camera")
    }
    kept |= {"name": said.name or path.stem, "landing_below_m": said.landing_below_m or 0.0}
    return Vehicle(**kept, reserve_s=reserve_s, camera=camera)


_REQUIRED = {
    "speed_mps": "metres a second",
    "accel_mps2": "metres a second squared",
    "climb_mps": "metres a second",
    "descent_mps": "metres a second",
    "endurance_s": "seconds",
}


def _check_required(faults: Faults, said: VehicleFile) -> None:
    for key, unit in _REQUIRED.items():
        if getattr(said, key) is None:
            faults.add(key, "nothing came", f"expected {unit}")
    if not any(faults.among(key) for key in ("landing_mps", "landing_below_m")):
        if said.landing_mps is not None and said.landing_below_m is None:
            faults.add("landing_below_m", "nothing came beside landing_mps", "expected metres above ground")
        if said.landing_mps is None and said.landing_below_m is not None:
            faults.add("landing_mps", "nothing came beside landing_below_m", "expected metres a second")


def _check_speeds(faults: Faults, said: VehicleFile) -> None:
    if said.speed_mps is not None and said.airspeed_mps is not None and said.airspeed_mps < said.speed_mps:
        came = f"{said.airspeed_mps:g} came, and speed_mps = {said.speed_mps:g}"
        faults.add("airspeed_mps", came, "expected at least that: it is what still air lets it fly")
    if said.landing_mps is not None and said.descent_mps is not None and said.landing_mps > said.descent_mps:
        came = f"{said.landing_mps:g} came, and descent_mps = {said.descent_mps:g}"
        faults.add("landing_mps", came, "expected at most that")


def _reserve_s(faults: Faults, said: VehicleFile) -> float:
    """Seconds that are kept, whichever way the file says it."""
    if faults.among("reserve"):
        return 0.0
    if said.reserve is None and said.reserve_s is None:
        expected = "expected the share of endurance_s that is never planned with, or reserve_s; 0 for none, on purpose"
        faults.add("reserve", "nothing came", expected)
    elif said.reserve is not None and said.reserve_s is not None:
        faults.add("reserve", f"{said.reserve:g} came, and reserve_s = {said.reserve_s:g}", "expected one of them")
    elif said.reserve_s is not None and said.endurance_s is not None and said.reserve_s >= said.endurance_s:
        came = f"{said.reserve_s:g} came, and endurance_s = {said.endurance_s:g}"
        faults.add("reserve_s", came, "expected less than that: nothing is left to fly with")
    share = (said.reserve or 0.0) * (said.endurance_s or 0.0)
    return share if said.reserve_s is None else said.reserve_s


def _check_dji(faults: Faults, said: VehicleFile) -> None:
    if said.dji is not None and said.dji not in DJI_MODELS:
        faults.add("dji", f"{said.dji!r} came", f"expected one of {', '.join(DJI_MODELS)}")
    elif said.dji is not None and said.kind == "fixed_wing":
        faults.add("dji", f"{said.dji!r} came, and kind = 'fixed_wing'", "expected it left out: these are copters")


def _camera(faults: Faults, said: VehicleCamera | None) -> Camera | None:
    if said is None:
        return None
    for key in VehicleCamera.model_fields:
        if getattr(said, key) is None and not faults.among("camera"):
            faults.add(f"camera.{key}", "nothing came", f"expected {', '.join(VehicleCamera.model_fields)}")
    if said.fov_deg is None or said.pixels is None or said.exposure_s is None:
        return None
    camera = Camera(radians(said.fov_deg), said.pixels, said.exposure_s)
    if camera.largest_speed(1.0) <= 0:
        came = f"exposure_s = {said.exposure_s:g} came, with which turns of the vehicle alone blur the picture"
        faults.add("camera", came, "expected a shorter exposure, fewer pixels or a wider view")
    return camera
