"""What a file must know of the aircraft that flies it."""

from __future__ import annotations

from dataclasses import dataclass

from sooner.errors import DataFormatError, Fault

__all__ = ["AUTOPILOTS", "DJI_MODELS", "Aircraft", "DjiModel"]

AUTOPILOTS = {"ardupilot": 3, "px4": 12}
"""MAVLink's numbers of autopilots (MAV_AUTOPILOT)."""


@dataclass(frozen=True)
class DjiModel:
    """DJI's numbers of an aircraft and of its own camera, as WPML wants them; None where cameras are exchanged."""

    drone: int
    sub: int
    payload: int | None = None


DJI_MODELS = {
    "m300": DjiModel(60, 0),
    "m350": DjiModel(89, 0),
    "m30": DjiModel(67, 0, 52),
    "m30t": DjiModel(67, 1, 53),
    "m3e": DjiModel(77, 0, 66),
    "m3t": DjiModel(77, 1, 67),
    "m3d": DjiModel(91, 0, 80),
    "m3td": DjiModel(91, 1, 81),
}


@dataclass(frozen=True)
class Aircraft:
    """Which autopilot and which DJI aircraft files are written for.

    Parameters
    ----------
    autopilot : str     of `AUTOPILOTS`
    dji : str           of `DJI_MODELS`

    Raises
    ------
    DataFormatError     if one of them is not known
    """

    autopilot: str = "ardupilot"
    dji: str = "m30t"

    def __post_init__(self) -> None:
        for option, came, known in (("--autopilot", self.autopilot, AUTOPILOTS), ("--dji", self.dji, DJI_MODELS)):
            if came not in known:
                raise DataFormatError(Fault(option, "", f"{came!r} came", f"expected one of {', '.join(known)}"))

    @property
    def firmware(self) -> int:
        """MAVLink's number of the autopilot."""
        return AUTOPILOTS[self.autopilot]

    @property
    def model(self) -> DjiModel:
        """DJI's numbers."""
        return DJI_MODELS[self.dji]
