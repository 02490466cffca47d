"""The reference page of the vehicle file, written from what is checked."""

from __future__ import annotations

from sooner.io.reference import about, keys_table
from sooner.missions.vehicles import VehicleCamera, VehicleFile

__all__ = ["vehicle_page"]

_EXAMPLE = """\
```toml
name = "Example: medium copter"
speed_mps = 12.0              # over the ground
accel_mps2 = 2.0
airspeed_mps = 17.0           # the most through the air: what is left of it against the wind
climb_mps = 4.0
descent_mps = 3.0
endurance_s = 1800            # of one full battery
reserve = 0.2                 # never planned with; or reserve_s = 360
swap_s = 180                  # on the ground between batteries
takeoff_s = 10
landing_mps = 0.5             # of the last metres down
landing_below_m = 10.0
[camera]
fov_deg = 60.0
pixels = 3000
exposure_s = 0.0005
```
"""

_TIME = """\
## Time

A leg is flown straight from rest to rest: speed grows by `accel_mps2` to the most that all limits let it be, and falls
again. The most is `speed_mps`; or against a wind, w along the leg and u across it, w + sqrt(`airspeed_mps`^2 - u^2); or
what `climb_mps` and `descent_mps` leave on a slope, where the flight follows the ground; or up to which the camera's
pictures are sharp. In a wind as strong as `airspeed_mps` nothing is flown.

One battery's flight has `endurance_s` less the reserve, less the time to climb and the time to land:

- up: `takeoff_s`, then the altitude at `climb_mps` and `accel_mps2`, from rest to rest;
- down: likewise at `descent_mps`, and from `landing_below_m` on at `landing_mps`.

## Where numbers come from

From the aircraft's own manual, and better from its logs: endurance with the payload and in the cold that it will fly
in, acceleration as its autopilot is set (ArduCopter: `WPNAV_ACCEL`, PX4: `MPC_ACC_HOR`). We ship no aircraft's data.
[Three examples](vehicles), a small, a medium and a large copter, show how files look; their numbers are round, made up
and of no aircraft.
"""


def vehicle_page() -> str:
    """`docs/vehicle_file.md`, as Markdown."""
    parts = [
        "# The vehicle file",
        "A vehicle file is TOML and describes one aircraft. Every fault of it is reported at once, with file, key, "
        "what came and what was expected.",
        _EXAMPLE.strip(),
        f"## At the top\n\n{keys_table(VehicleFile, {VehicleCamera: 'table'})}",
        f"## `[camera]`\n\n{about(VehicleCamera)}\n\n{keys_table(VehicleCamera, {})}",
        _TIME.strip(),
    ]
    return "\n\n".join(parts) + "\n"
