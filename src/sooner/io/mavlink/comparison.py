"""What a vehicle holds against what it was sent, item by item."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isclose

from sooner.io.flights.mission_items import NOWHERE, MissionItem
from sooner.io.mavlink.items import Part

__all__ = ["PLACE_DEG", "differences"]

PLACE_DEG = 1e-7  # MAVLink's unit of positions
FLOAT32 = 2.0**-22  # relative; floats of 32 bits have 24 binary digits
CENTIMETRE = 0.011  # ArduPilot keeps heights in whole centimetres, cut off

# with and without _INT frames mean the same
SAME_FRAME = {5: 0, 6: 3, 11: 10}
COMMANDS = {
    16: "waypoint",
    17: "loiter",
    20: "return",
    21: "land",
    22: "take off",
    178: "speed",
    5001: "stay inside",
    5002: "stay out",
    5100: "rally point",
}


def differences(
    part: Part, sent: Sequence[MissionItem], held: Sequence[MissionItem], count: int, ardupilot: bool
) -> tuple[str, ...]:
    """Each difference as a sentence; none where the vehicle holds what it was sent.

    Positions may differ by one unit of 1e-7 degrees, altitudes and parameters as floats of 32 bits do, and
    ArduPilot's altitudes by the centimetre that it keeps them in. What was left to the autopilot is not compared,
    nor is the frame of a command without a place; ArduPilot's first item is home, which it sets itself.

    Parameters
    ----------
    sent, held : of MissionItem
    count : int                 how many items the vehicle says it holds

    Examples
    --------
    >>> from sooner.io.mavlink.items import MISSION
    >>> sent = MissionItem(16, 3, (0.0, 0.0, 0.0, None), 46.0, 11.0, 60.0)
    >>> held = MissionItem(16, 3, (0.0, 0.0, 0.0, 0.0), 46.0, 11.0, 80.0)
    >>> differences(MISSION, [sent], [held], 1, ardupilot=False)
    ('mission item 0 (waypoint): altitude 60 was sent, 80 came back',)
    """
    told = [] if count == len(sent) else [f"{part.name}: {len(sent)} items were sent, the vehicle holds {count}"]
    up_m = CENTIMETRE if ardupilot else 0.0
    for number, (ours, theirs) in enumerate(zip(sent, held, strict=False)):
        if number == 0 and ardupilot and part.number == 0:
            continue
        name = COMMANDS.get(ours.command, f"command {ours.command}")
        where = f"{part.name} item {number} ({name})"
        told += [
            f"{where}: {what} {came} was sent, {back} came back" for what, came, back in _pairs(ours, theirs, up_m)
        ]
    return tuple(told)


def _pairs(ours: MissionItem, theirs: MissionItem, up_m: float) -> Iterator[tuple[str, str, str]]:
    """What differs: its name, what was sent, what came back."""
    if ours.command != theirs.command:
        yield "command", str(ours.command), str(theirs.command)
        return
    if ours.frame != NOWHERE and SAME_FRAME.get(ours.frame, ours.frame) != SAME_FRAME.get(theirs.frame, theirs.frame):
        yield "frame", str(ours.frame), str(theirs.frame)
    for number, (came, back) in enumerate(zip(ours.settings, theirs.settings, strict=True), start=1):
        if came is not None and not _same(came, back):
            yield f"parameter {number}", f"{came:g}", "nothing" if back is None else f"{back:g}"
    for name, place, found in (("latitude", ours.lat, theirs.lat), ("longitude", ours.lon, theirs.lon)):
        if abs(round(place / PLACE_DEG) - round(found / PLACE_DEG)) > 1:
            yield name, f"{place:.7f}", f"{found:.7f}"
    if not _same(ours.altitude_m, theirs.altitude_m, up_m):
        yield "altitude", f"{ours.altitude_m:g}", f"{theirs.altitude_m:g}"


def _same(came: float, back: float | None, within: float = 0.0) -> bool:
    return back is not None and isclose(came, back, rel_tol=FLOAT32, abs_tol=max(within, 1e-9))
