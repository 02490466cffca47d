"""MAVLink's mission protocol: COUNT, REQUEST, ITEM_INT, ACK to send a list, REQUEST_LIST to read it back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isnan, nan
from typing import Any

from sooner.errors import Fault
from sooner.io.flights.mission_items import MissionItem
from sooner.io.mavlink.items import Part
from sooner.io.mavlink.patience import Patience
from sooner.io.mavlink.refusal import ACCEPTED, CANCELLED, NO_SPACE, OUT_OF_TURN, VehicleError, meaning
from sooner.io.mavlink.vehicle import ARDUPILOT, Talk

__all__ = ["Lists"]

REQUESTS, ACK, COUNT, ITEM = (
    ("MISSION_REQUEST", "MISSION_REQUEST_INT"),
    "MISSION_ACK",
    "MISSION_COUNT",
    "MISSION_ITEM_INT",
)
UNITS = 10_000_000  # a degree


@dataclass(frozen=True)
class _Offered:
    """How an offer ended: MAV_MISSION_RESULT, None for silence, and how many items had been asked for."""

    result: int | None
    asked: int


@dataclass(frozen=True)
class Lists:
    """The lists that a vehicle holds, over a talk with it."""

    talk: Talk
    patience: Patience

    # ------------------------------------------------------------ sending

    def put(self, part: Part, items: Sequence[MissionItem]) -> None:
        """Send a list, and have it acknowledged.

        A transfer that breaks off is begun anew; a vehicle without space is asked again later, as ArduPilot says so
        while it wakes up.

        Raises
        ------
        VehicleError          in the vehicle's words, or where it is silent
        """
        tries, waits, furthest = self.patience.tries, self.patience.busy_tries, 0
        while True:
            offered = self._offer(part, items)
            furthest = max(furthest, offered.asked)
            if offered.result == ACCEPTED:
                return
            if offered.result == NO_SPACE and waits > 0:
                waits -= 1
                self.talk.wait(self.patience.busy_s)
            elif offered.result in (None, CANCELLED, OUT_OF_TURN) and tries > 1:
                tries -= 1
            else:
                raise self._refusal(part, replace(offered, asked=furthest), len(items))

    def _offer(self, part: Part, items: Sequence[MissionItem]) -> _Offered:
        """One transfer. The vehicle asks for items, more than once where it hears none; so whatever it asks it gets."""
        self.talk.send(self.talk.mavlink.MAVLink_mission_count_message(*self.talk.target, len(items), part.number))
        asked, result = 0, None
        for _ in range(20 * len(items) + 100):  # a vehicle that asks for ever is not answered for ever
            seconds = self.patience.silence_s if asked else self.patience.answer_s
            told = self._next((*REQUESTS, ACK), part, seconds)
            if told is None:
                return _Offered(result, asked)
            if told.get_type() != ACK:
                if told.seq < len(items):
                    self.talk.send(self._message(part, told.seq, items[told.seq]))
                    asked, result = max(asked, told.seq + 1), None
            elif told.type == OUT_OF_TURN:
                result = OUT_OF_TURN  # of an item that came twice: it goes on asking
            elif told.type != ACCEPTED or asked == len(items):  # accepted before all were asked for: an older answer
                return _Offered(told.type, asked)
        return _Offered(result, asked)

    def _message(self, part: Part, number: int, item: MissionItem) -> Any:
        """An item as it is sent."""
        unsaid = 0.0 if self.talk.vehicle.autopilot == ARDUPILOT else nan
        settings = [unsaid if each is None else each for each in item.settings]
        current = int(number == 0 and part.number == 0)
        place = round(item.lat * UNITS), round(item.lon * UNITS), item.altitude_m
        told = number, item.frame, item.command, current, 1, *settings, *place, part.number
        return self.talk.mavlink.MAVLink_mission_item_int_message(*self.talk.target, *told)

    def cancel(self, part: Part) -> None:
        """Tell the vehicle that the rest of a list will not come."""
        self._acknowledge(part, CANCELLED)

    def clear(self, part: Part) -> None:
        """Have a list emptied.

        Raises
        ------
        VehicleError
        """
        message = self.talk.mavlink.MAVLink_mission_clear_all_message(*self.talk.target, part.number)
        told = self._asked(message, (ACK,), part)
        if told is None or told.type != ACCEPTED:
            raise self._refusal(part, _Offered(None if told is None else told.type, 0), 0)

    # ------------------------------------------------------------ reading

    def count(self, part: Part) -> int:
        """How many items the vehicle holds.

        Raises
        ------
        VehicleError
        """
        count = self._begun(part)
        self._acknowledge(part, CANCELLED if count else ACCEPTED)  # the items themselves are not wanted
        return count

    def read(self, part: Part, most: int) -> tuple[int, tuple[MissionItem, ...]]:
        """How many items the vehicle holds, and the first of them.

        Raises
        ------
        VehicleError
        """
        count, found = self._begun(part), []
        for number in range(min(count, most)):
            told = self._asked(
                self.talk.mavlink.MAVLink_mission_request_int_message(*self.talk.target, number, part.number),
                (ITEM,),
                part,
                number,
            )
            if told is None:
                raise self._silence(part, f"item {number} of {count}")
            found.append(_item(told))
        self._acknowledge(part, ACCEPTED)
        return count, tuple(found)

    def _begun(self, part: Part) -> int:
        """Begin to read; answers how many items there are."""
        message = self.talk.mavlink.MAVLink_mission_request_list_message(*self.talk.target, part.number)
        told = self._asked(message, (COUNT, ACK), part)
        if told is None:
            raise self._silence(part, "how many items it holds")
        if told.get_type() == ACK:
            raise self._refusal(part, _Offered(told.type, 0), 0)
        return int(told.count)

    # ------------------------------------------------------------ both

    def _acknowledge(self, part: Part, result: int) -> None:
        self.talk.send(self.talk.mavlink.MAVLink_mission_ack_message(*self.talk.target, result, part.number))

    def _asked(self, message: Any, names: tuple[str, ...], part: Part, number: int | None = None) -> Any:
        """The answer to a question, which is asked again where none comes; None for silence."""
        for _ in range(self.patience.tries):
            self.talk.send(message)
            told = self._next(names, part, self.patience.answer_s, number)
            if told is not None:
                return told
        return None

    def _next(self, names: tuple[str, ...], part: Part, seconds: float, number: int | None = None) -> Any:
        """The next message about this list, and of this number if one is given; None if none comes in time."""
        for told in self.talk.answers(names, seconds):
            if told.mission_type == part.number and (number is None or told.seq == number):
                return told
        return None

    def _silence(self, part: Part, what: str) -> VehicleError:
        came = f"the vehicle did not say {what}, asked {self.patience.tries} times"
        return VehicleError(Fault(f"vehicle {self.talk.vehicle.system}", part.name, came, "expected a link that holds"))

    def _refusal(self, part: Part, offered: _Offered, count: int) -> VehicleError:
        at = f" at {part.item} {offered.asked - 1} of {count}" if offered.asked else ""
        if offered.result is None:
            came = f"the vehicle fell silent{at}" if at else "the vehicle did not answer"
            came, expected = f"{came}, tried {self.patience.tries} times", "a link that holds"
        else:
            said, expected = meaning(offered.result)
            came = f"the vehicle refused{at}: {said}"
        where = f"vehicle {self.talk.vehicle.system}"
        return VehicleError(Fault(where, part.name, came, f"expected {expected}"), offered.result)


def _item(told: Any) -> MissionItem:
    """An item as it came back."""
    settings = (told.param1, told.param2, told.param3, told.param4)
    a, b, c, d = (None if isnan(each) else float(each) for each in settings)
    return MissionItem(told.command, told.frame, (a, b, c, d), told.x / UNITS, told.y / UNITS, float(told.z))
