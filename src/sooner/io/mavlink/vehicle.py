"""Which vehicle is at the other end: known by its heartbeat, and what it says it can do."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from sooner.errors import DataFormatError, Fault, printable
from sooner.io.flights import AUTOPILOTS
from sooner.io.mavlink.link import COMPONENT, SYSTEM, Link, Received
from sooner.io.mavlink.patience import Patience

__all__ = ["ARDUPILOT", "PX4", "Talk", "Vehicle", "find_vehicle"]

ARDUPILOT, PX4 = AUTOPILOTS["ardupilot"], AUTOPILOTS["px4"]
NO_AUTOPILOT = 8  # MAV_AUTOPILOT_INVALID: cameras, gimbals, ground stations
NO_VEHICLES = {5, 6, 18, 26, 27, 30}  # MAV_TYPE: antenna tracker, ground station, computer aboard, gimbal, ADSB, camera
ARMED = 128  # MAV_MODE_FLAG_SAFETY_ARMED
AUTOPILOT_VERSION, REQUEST_MESSAGE, REQUEST_CAPABILITIES = 148, 512, 520
WARNING, MOST_SAID = 4, 10


@dataclass(frozen=True)
class Vehicle:
    """A vehicle that was heard.

    Parameters
    ----------
    system, component : int
    autopilot : int             MAV_AUTOPILOT
    armed : bool
    version_2 : bool            it has spoken MAVLink 2
    capabilities : int or None  bits of MAV_PROTOCOL_CAPABILITY; None: it does not say
    """

    system: int
    component: int
    autopilot: int
    armed: bool
    version_2: bool = True
    capabilities: int | None = None

    @property
    def autopilot_name(self) -> str:
        """As people call it."""
        names = {0: "an autopilot of no known make", ARDUPILOT: "ArduPilot", PX4: "PX4"}
        return names.get(self.autopilot, f"autopilot {self.autopilot}")

    def __str__(self) -> str:
        return f"vehicle {self.system}: {self.autopilot_name}, {'armed' if self.armed else 'disarmed'}"


def find_vehicle(link: Link, where: str, patience: Patience, system: int | None = None) -> tuple[Vehicle, Received]:
    """Wait for its heartbeat; answers the vehicle, and the heartbeat.

    Raises
    ------
    DataFormatError         if none comes in time, or several vehicles are heard and none is named
    """
    until = time.monotonic() + patience.heartbeat_s
    found: dict[int, Received] = {}
    while (heard := link.receive(until)) is not None:
        if not _of_vehicle(heard) or (system is not None and heard.system != system):
            continue
        if not found:  # a named one has been found; else others may be about
            until = time.monotonic() + (0.0 if system is not None else patience.neighbours_s)
        if heard.system not in found or heard.component <= found[heard.system].component:  # 1 is the autopilot's
            found[heard.system] = heard
    if not found:
        wanted = "no heartbeat" if system is None else f"no heartbeat of vehicle {system}"
        came = f"{wanted} came within {patience.heartbeat_s:g} s"
        raise DataFormatError(Fault("--connect", where, came, "expected a vehicle that is switched on and sends there"))
    if len(found) > 1:
        came = f"heartbeats of vehicles {', '.join(map(str, sorted(found)))} came"
        raise DataFormatError(Fault("--connect", where, came, "expected --system to say which"))
    (heard,) = found.values()
    told = heard.message
    vehicle = Vehicle(heard.system, heard.component, told.autopilot, bool(told.base_mode & ARMED), heard.version_2)
    return vehicle, heard


def _of_vehicle(heard: Received) -> bool:
    if heard.name != "HEARTBEAT" or heard.system in (0, SYSTEM):
        return False
    return bool(heard.message.autopilot != NO_AUTOPILOT and heard.message.type not in NO_VEHICLES)


class Talk:
    """What is said with one vehicle; what others say is passed over.

    Attributes
    ----------
    vehicle : Vehicle       as last heard
    said : list of str      what it warned of meanwhile
    """

    def __init__(self, link: Link, vehicle: Vehicle, first: Received) -> None:
        self.link, self.vehicle, self._sender = link, vehicle, first.sender
        self.said: list[str] = []

    @property
    def mavlink(self) -> Any:
        """pymavlink's messages."""
        return self.link.mavlink

    @property
    def target(self) -> tuple[int, int]:
        """System and component."""
        return self.vehicle.system, self.vehicle.component

    def send(self, message: Any) -> None:
        """To the vehicle, wherever it was last heard."""
        self.link.send(message, self._sender)

    def answers(self, names: tuple[str, ...], seconds: float) -> Iterator[Any]:
        """Its messages of these names for us, until the time is over."""
        until = time.monotonic() + seconds
        while (heard := self.link.receive(until)) is not None:
            if (heard.system, heard.component) != self.target:
                continue
            self._sender = heard.sender
            self._note(heard)
            if heard.name in names and _for_us(heard.message):
                yield heard.message

    def wait(self, seconds: float) -> None:
        """Listen, and keep the link alive."""
        for _ in self.answers((), seconds):
            pass

    def learn_capabilities(self, patience: Patience) -> None:
        """Ask the vehicle what it can do; one that does not say may still be able."""
        for request in (REQUEST_MESSAGE, REQUEST_CAPABILITIES):
            parameters = (AUTOPILOT_VERSION if request == REQUEST_MESSAGE else 1, 0, 0, 0, 0, 0, 0)
            self.send(self.mavlink.MAVLink_command_long_message(*self.target, request, 0, *parameters))
            for told in self.answers(("AUTOPILOT_VERSION",), patience.answer_s):
                self.vehicle = replace(self.vehicle, capabilities=int(told.capabilities))
                return

    def _note(self, heard: Received) -> None:
        """Keep what it says of itself."""
        if heard.version_2 and not self.vehicle.version_2:
            self.vehicle = replace(self.vehicle, version_2=True)
        if heard.name == "HEARTBEAT" and _of_vehicle(heard):
            self.vehicle = replace(self.vehicle, armed=bool(heard.message.base_mode & ARMED))
        elif heard.name == "STATUSTEXT" and heard.message.severity <= WARNING and len(self.said) < MOST_SAID:
            text = heard.message.text
            line = printable(text.decode(errors="replace") if isinstance(text, bytes) else text).strip()
            if line and line not in self.said:
                self.said.append(line)


def _for_us(message: Any) -> bool:
    """Addressed to us, or to everybody."""
    system, component = getattr(message, "target_system", 0), getattr(message, "target_component", 0)
    return system in (0, SYSTEM) and component in (0, COMPONENT)
