"""MAVLink 2 over a channel: messages out, messages in, and a heartbeat of our own once a second."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from sooner.errors import UnsupportedProblemError
from sooner.io.mavlink.connection import Channel, Sender
from sooner.io.mavlink.frames import VERSION_2, messages

__all__ = ["COMPONENT", "SYSTEM", "Link", "Received", "dialect"]

# Not the usual 255: ArduPilot lands or comes home where that ground station falls silent, and we do when we are done
SYSTEM, COMPONENT = 254, 190
BEAT_S = 1.0


def dialect() -> Any:
    """pymavlink's messages.

    Raises
    ------
    UnsupportedProblemError     if it is not installed
    """
    try:
        from pymavlink.dialects.v20 import common
    except ImportError:
        raise UnsupportedProblemError("an upload needs pymavlink: pip install 'sooner[aircraft]'") from None
    return common


@dataclass(frozen=True)
class Received:
    """A message, who sent it, and from where."""

    message: Any
    name: str
    system: int
    component: int
    sender: Sender
    version_2: bool


class Link:
    """A channel that carries messages."""

    def __init__(self, channel: Channel) -> None:
        self.mavlink = dialect()
        self.channel = channel
        self._speaker = self.mavlink.MAVLink(None, SYSTEM, COMPONENT)
        self._unread = bytearray()
        self._pending: deque[Received] = deque()
        self._beaten = -BEAT_S

    def send(self, message: Any, to: Sender = None) -> None:
        """To one of those who were heard, or to all."""
        self.channel.send(bytes(message.pack(self._speaker)), to)
        self._speaker.seq = (self._speaker.seq + 1) % 256

    def receive(self, until: float) -> Received | None:
        """The next message that arrives before a time of the monotonic clock; garbage is passed over."""
        while not self._pending:
            now = time.monotonic()
            if now >= self._beaten + BEAT_S:
                self._beat()
                self._beaten = now
            if now >= until:
                return None
            found = self.channel.receive(min(until, self._beaten + BEAT_S) - now)
            if found is not None:
                self._pending.extend(self._parsed(*found))
        return self._pending.popleft()

    def _beat(self) -> None:
        mavlink = self.mavlink
        self.send(mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4, 3))

    def _parsed(self, data: bytes, sender: Sender) -> Iterator[Received]:
        """Messages in what arrived."""
        self._unread += data
        for message in messages(self.mavlink, self._speaker, self._unread, self.channel.whole):
            version_2 = message.get_msgbuf()[0] == VERSION_2
            told = message.get_srcSystem(), message.get_srcComponent()
            yield Received(message, message.get_type(), *told, sender, version_2)
