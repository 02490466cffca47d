"""What a vehicle says when it does not take a flight, in words."""

from __future__ import annotations

from sooner.errors import DataFormatError, Fault

__all__ = ["ACCEPTED", "CANCELLED", "NO_SPACE", "OUT_OF_TURN", "UNSUPPORTED", "VehicleError", "meaning"]

ACCEPTED, UNSUPPORTED, NO_SPACE, OUT_OF_TURN, CANCELLED = 0, 3, 4, 13, 15  # MAV_MISSION_RESULT

_MEANINGS = {
    1: ("it failed, and it does not say why", "a vehicle that is awake and idle: try again"),
    2: ("it does not know what the altitudes count from", "a vehicle that flies above home"),
    3: ("it does not know this kind of item", "a vehicle that does"),
    4: ("it has no space for so many items", "a shorter flight, or a vehicle with more memory"),
    5: ("an item is not valid", "a flight that this vehicle can fly"),
    **{
        5 + number: (f"parameter {number} of an item is not valid", "a flight that this vehicle can fly")
        for number in (1, 2, 3, 4)
    },
    10: ("a latitude is not valid", "places that this vehicle can fly to"),
    11: ("a longitude is not valid", "places that this vehicle can fly to"),
    12: ("an altitude is not valid", "altitudes that this vehicle can fly at"),
    13: ("items came out of turn", "a link that loses less: try again"),
    14: ("it takes none now", "a vehicle that nobody else is sending a flight to: try again"),
    15: ("it broke the transfer off", "a vehicle that is awake and idle: try again"),
}


def meaning(result: int) -> tuple[str, str]:
    """What a MAV_MISSION_RESULT says, and what would have been taken.

    >>> meaning(10)
    ('a latitude is not valid (MAV_MISSION_RESULT 10)', 'places that this vehicle can fly to')
    """
    said, expected = _MEANINGS.get(result, ("it gives a reason that MAVLink does not know", "another vehicle"))
    return f"{said} (MAV_MISSION_RESULT {result})", expected


class VehicleError(DataFormatError):
    """A vehicle did not take, or did not tell, what it was asked; `result` is MAVLink's number, None for silence."""

    def __init__(self, fault: Fault, result: int | None = None) -> None:
        super().__init__(fault)
        self.fault, self.result = fault, result
