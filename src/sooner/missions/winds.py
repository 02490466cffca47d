"""A mission's wind, as weather services tell it, and whether a vehicle can fly in it."""

from __future__ import annotations

from math import atan2, cos, radians, sin

from pydantic import BaseModel, ConfigDict, Field

from sooner.errors import Fault, InvalidProblemError
from sooner.io.georeference import Georeference
from sooner.motion.wind import Wind, check_wind

__all__ = ["WindSettings", "wind_fault"]

_NEARBY_DEG = 1e-4  # some 11 m to the north, whichever way that is on a map


class WindSettings(BaseModel):
    """`[wind]`: the same everywhere and all the time; left out: none.

    A leg against it takes longer, one with it no less than its speed asks for. Where it is as strong as a drone flies
    through the air, no drone holds its place, and the mission is refused.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    speed_mps: float = Field(default=0.0, ge=0, le=200, allow_inf_nan=False, description="metres a second")
    from_deg: float = Field(
        default=0.0, ge=0, le=360, allow_inf_nan=False, description="where it comes from: 0 north, 90 east"
    )

    @property
    def blows_to(self) -> Wind:
        """Metres a second to the true east and north.

        >>> east, north = WindSettings(speed_mps=8.0, from_deg=270.0).blows_to
        >>> round(east, 9), round(north, 9) + 0.0
        (8.0, 0.0)
        """
        return self._toward(radians(self.from_deg))

    def over(self, ground: Georeference, shape: tuple[int, int]) -> Wind:
        """Metres a second along the columns of a raster and up its rows, whose north may lean away from the true one.

        True north is that in the middle of the raster, (H, W). The projections of a whole continent lean by up to some
        thirty degrees, those of a UTM zone by up to three at middle latitudes.

        >>> finland = Georeference("EPSG:3035", (5_100_000.0, 4_800_000.0), 100.0, 100.0)
        >>> east, north = WindSettings(speed_mps=10.0, from_deg=0.0).over(finland, (100, 100))
        >>> round(east, 1), round(north, 1)
        (2.6, -9.7)
        """
        middle = ((shape[0] - 1) / 2, (shape[1] - 1) / 2)
        ((lat, lon),) = ground.places([middle])
        (south, north) = ground.cells([[lat - _NEARBY_DEG, lon], [lat + _NEARBY_DEG, lon]])
        lean = atan2(north[1] - south[1], south[0] - north[0])  # clockwise from the map's north to the true one
        return self._toward(radians(self.from_deg) + lean)

    def _toward(self, bearing: float) -> Wind:
        return (-self.speed_mps * sin(bearing), -self.speed_mps * cos(bearing))


def wind_fault(file: str, wind: WindSettings | None, vehicle: str, airspeed_mps: float | None) -> Fault | None:
    """Why a vehicle cannot fly in a wind, as a fault of the mission's file; None where it can.

    >>> print(wind_fault("ridge.toml", WindSettings(speed_mps=12.0, from_deg=270.0), "small.toml", 10.0))
    ridge.toml: wind.speed_mps: 12 m/s from 270 degrees came, and small.toml flies at most 10 m/s through the air; expected less than that: wait for less wind, or take a faster vehicle
    """  # noqa: E501
    if wind is None or wind.speed_mps == 0.0:
        return None
    came = f"{wind.speed_mps:g} m/s from {wind.from_deg:g} degrees came"
    if airspeed_mps is None:
        return Fault(
            file,
            "wind.speed_mps",
            f"{came}, and {vehicle} does not say how fast it flies through the air",
            "expected airspeed_mps there, or no wind",
        )
    try:
        check_wind(airspeed_mps, wind.blows_to)
    except InvalidProblemError:
        came += f", and {vehicle} flies at most {airspeed_mps:g} m/s through the air"
        return Fault(
            file, "wind.speed_mps", came, "expected less than that: wait for less wind, or take a faster vehicle"
        )
    return None
