"""A flight goes to a vehicle: fence, rally points and mission, each sent, read back and compared."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field, replace

from sooner.errors import DataFormatError, Fault
from sooner.io.flights import FlightPlan
from sooner.io.flights.mission_items import WAYPOINT, MissionItem
from sooner.io.georeference import ground_m
from sooner.io.mavlink.comparison import differences
from sooner.io.mavlink.connection import Connection
from sooner.io.mavlink.items import FENCE, MISSION, RALLY, Part, items_of
from sooner.io.mavlink.link import Link, dialect
from sooner.io.mavlink.mission_protocol import Lists
from sooner.io.mavlink.patience import Patience
from sooner.io.mavlink.refusal import UNSUPPORTED, VehicleError
from sooner.io.mavlink.vehicle import ARDUPILOT, PX4, Talk, Vehicle, find_vehicle

__all__ = ["Checked", "Uploaded", "upload"]

FAR_M = 100.0  # between the home of a flight and that of the vehicle, untold


@dataclass(frozen=True)
class Checked:
    """One list after it was read back.

    Parameters
    ----------
    part : str                  "fence", "rally points" or "mission"
    sent, held : int            items sent; items that the vehicle says it holds
    differences : of str        empty where it holds what it was sent
    """

    part: str
    sent: int
    held: int
    differences: tuple[str, ...] = ()


@dataclass(frozen=True)
class Uploaded:
    """What a vehicle took of a flight.

    Parameters
    ----------
    vehicle : Vehicle
    checked : of Checked        the lists that it was sent, or that were cleared
    notes : of str              what whoever flies it should know
    """

    vehicle: Vehicle
    checked: tuple[Checked, ...]
    notes: tuple[str, ...]

    @property
    def same(self) -> bool:
        """The vehicle holds what it was sent."""
        return not any(each.differences for each in self.checked)


def upload(
    plan: FlightPlan,
    connection: Connection,
    autopilot: int | None = None,
    system: int | None = None,
    force: bool = False,
    patience: Patience | None = None,
    tell: Callable[[str], None] = lambda line: None,
) -> Uploaded:
    """Send a flight to a vehicle, read it back and compare; it arms nothing and starts nothing.

    The fence goes first, so that the autopilot checks the mission against it and not against an older one, and the
    mission last. A fence or rally points that the vehicle holds and the flight does not have are cleared: they belong
    to another flight. Where the vehicle knows none, the mission goes without.

    Parameters
    ----------
    plan : FlightPlan
    connection : Connection
    autopilot : int or None     MAV_AUTOPILOT; None: as its heartbeat says
    system : int or None        which vehicle, where several are heard
    force : bool                even while it is armed
    patience : Patience
    tell : callable             takes each line of progress

    Raises
    ------
    DataFormatError             if no vehicle is heard, or it is armed
    VehicleError                in the vehicle's words, or where it falls silent
    UnsupportedProblemError     if pymavlink is not installed
    KeyboardInterrupt           with what the vehicle then holds
    """
    dialect()
    patience = patience or Patience()
    with _nothing_changed(), closing(connection.opened()) as channel:
        tell(f"waiting for a heartbeat at {connection}")
        link = Link(channel)
        vehicle, first = find_vehicle(link, str(connection), patience, system)
        if autopilot is not None:
            vehicle = replace(vehicle, autopilot=autopilot)
        talk = Talk(link, vehicle, first)
        tell(str(vehicle))
        _check_disarmed(talk, force)
        talk.learn_capabilities(patience)
        return _Upload(plan, talk, Lists(talk, patience), force, tell).done()


@contextmanager
def _nothing_changed() -> Iterator[None]:
    """An interruption that nobody else has put into words came before the mission was sent."""
    try:
        yield
    except KeyboardInterrupt as error:
        raise error if error.args else KeyboardInterrupt("interrupted; the vehicle's mission is as it was") from None


def _check_disarmed(talk: Talk, force: bool) -> None:
    if talk.vehicle.armed and not force:
        expected = "expected one on the ground and disarmed; --force replaces the mission that it may be flying"
        raise DataFormatError(Fault(f"vehicle {talk.vehicle.system}", "", "an armed vehicle came", expected))


@dataclass
class _Upload:
    """One upload; `notes` and `checked` grow as it goes on."""

    plan: FlightPlan
    talk: Talk
    lists: Lists
    force: bool
    tell: Callable[[str], None]
    notes: list[str] = field(default_factory=list)
    checked: list[Checked] = field(default_factory=list)

    def done(self) -> Uploaded:
        """All lists, one after the other."""
        for part in (FENCE, RALLY):
            self._put_or_clear(part, items_of(self.plan, part, self.ardupilot))
        self._put(MISSION, items_of(self.plan, MISSION, self.ardupilot))
        with suppress(KeyboardInterrupt):  # all is done
            self.talk.wait(self.lists.patience.warnings_s)
        if self.talk.vehicle.armed:
            self.notes.append("the vehicle is armed")
        self.notes += self._fenced()
        self.notes += [f"the vehicle says: {line}" for line in self.talk.said]
        return Uploaded(self.talk.vehicle, tuple(self.checked), tuple(self.notes))

    @property
    def ardupilot(self) -> bool:
        return self.talk.vehicle.autopilot == ARDUPILOT

    # ------------------------------------------------------------ one list

    def _put_or_clear(self, part: Part, items: tuple[MissionItem, ...]) -> None:
        """A list that a flight need not have, and a vehicle need not know."""
        held = self._held(part)
        if held is not None and items:
            try:
                self._put(part, items)
                return
            except VehicleError as refusal:
                if refusal.result != UNSUPPORTED or self._held(part):
                    raise
                held = None
        if held is None and items:
            why = "" if self.talk.vehicle.version_2 else ", as it speaks MAVLink 1"
            self.notes.append(f"the vehicle takes no {part.name}{why}: the flight's {len(items)} items were not sent")
        elif held:
            self._clear(part, held)

    def _held(self, part: Part) -> int | None:
        """How many items the vehicle holds; None where it has no such list.

        MAVLink 1 has none, and would take it for the mission. A vehicle that does not say what it can do may be
        silent about what it cannot.
        """
        vehicle = self.talk.vehicle
        if not vehicle.version_2 or (vehicle.capabilities is not None and not vehicle.capabilities & part.capability):
            return None
        try:
            return self.lists.count(part)
        except VehicleError as refusal:
            if refusal.result == UNSUPPORTED or (refusal.result is None and vehicle.capabilities is None):
                return None
            raise

    def _put(self, part: Part, items: tuple[MissionItem, ...]) -> None:
        _check_disarmed(self.talk, self.force)
        self.tell(f"sending the {part.name}: {len(items)} items")
        with self._broken_off(f"while the {part.name} was sent", part, self._state(part)):
            self.lists.put(part, items)
        self.tell(f"reading the {part.name} back")
        with self._broken_off(
            f"while the {part.name} was read back", part, "the vehicle took it, and it is not checked"
        ):
            count, held = self.lists.read(part, len(items))
        told = differences(part, items, held, count, self.ardupilot)
        self.checked.append(Checked(part.name, len(items), count, told))
        if part is MISSION:
            self.notes += self._at_home(held)

    def _clear(self, part: Part, held: int) -> None:
        _check_disarmed(self.talk, self.force)
        self.tell(f"clearing the {part.name} that the vehicle holds")
        self.lists.clear(part)
        count = self.lists.count(part)
        left = (
            (f"{part.name}: the vehicle was told to clear this list, and still holds {count} items",) if count else ()
        )
        self.checked.append(Checked(part.name, 0, count, left))
        if not left:
            self.notes.append(f"{part.name}: the vehicle held {held} items of another flight, which were cleared")

    # ------------------------------------------------------------ words

    @contextmanager
    def _broken_off(self, when: str, part: Part, state: str) -> Iterator[None]:
        """Whatever ends a transfer early also tells what the vehicle then holds."""
        before = ", ".join(each.part for each in self.checked)
        mission = "" if part is MISSION else "; its mission is as it was"
        told = f"{state}{mission}" + (f"; replaced before: {before}" if before else "")
        try:
            yield
        except KeyboardInterrupt:
            self.lists.cancel(part)
            raise KeyboardInterrupt(f"interrupted {when}: {told}") from None
        except DataFormatError as error:
            (fault,) = error.faults
            result = error.result if isinstance(error, VehicleError) else None
            raise VehicleError(replace(fault, expected=f"{fault.expected}; {told}"), result) from None

    def _state(self, part: Part) -> str:
        """What a vehicle holds after a transfer that broke off."""
        if self.talk.vehicle.autopilot == PX4 and part is MISSION:
            return "PX4 keeps its old mission until the last item has come"
        return f"the vehicle may hold a part of the new {part.name} and a part of the old: upload again before it flies"

    def _fenced(self) -> Iterator[str]:
        if not any(each.part == FENCE.name and each.sent for each in self.checked):
            return
        if self.ardupilot:
            yield "the fence is loaded, not switched on: FENCE_ENABLE and FENCE_TYPE say whether it counts"
        elif self.talk.vehicle.autopilot == PX4:
            yield "the fence is loaded: GF_ACTION says what PX4 does at it"
        else:
            yield "the fence is loaded: whether it is switched on, the vehicle's settings say"

    def _at_home(self, held: tuple[MissionItem, ...]) -> Iterator[str]:
        """ArduPilot's first item is where it believes home to be."""
        if not self.ardupilot or not held or held[0].command != WAYPOINT:
            return
        home = held[0].lat, held[0].lon
        if home == (0.0, 0.0):
            yield "the vehicle does not know its home yet"
        elif (metres := float(ground_m([self.plan.home, home]).sum())) > FAR_M:
            yield f"the vehicle's home is {metres:,.0f} m from where the flight begins"
