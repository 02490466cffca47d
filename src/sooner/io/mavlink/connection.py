"""Where a vehicle is: `udp:127.0.0.1:14550` and the like, and the bytes that go there and come from there."""

from __future__ import annotations

import os
import re
import select
import socket
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

from sooner.errors import DataFormatError, Fault

__all__ = ["Channel", "Connection", "Sender"]

KNOWN = "expected udp:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or serial:DEVICE:BAUD"
USUAL_BAUD = 57_600
CONNECT_S = 10.0
MOST_BYTES = 65_535
_URL = re.compile(r"(udp|udpin|udpout|tcp|tcpout|serial):(?://)?(.*)", re.DOTALL)
_KINDS = {"udp": "udpin", "tcpout": "tcp"}

Sender = tuple[Any, ...] | None
"""Whoever sent a datagram; None on a line that has one other end."""


class Channel(Protocol):
    """An open connection; `whole`: each piece received holds whole messages."""

    whole: bool

    def receive(self, seconds: float) -> tuple[bytes, Sender] | None:
        """The next bytes and who sent them; None if none came in that time."""

    def send(self, data: bytes, to: Sender) -> None:
        """Bytes for somebody; for all who were heard if that is None."""

    def close(self) -> None:
        """No more of it."""


@dataclass(frozen=True)
class Connection:
    """How a vehicle is reached.

    Parameters
    ----------
    kind : str          "udpin": wait at a port for what the vehicle sends, and answer; "udpout": send first;
                        "tcp": connect; "serial"
    where : str         host or address; device
    number : int        port; baud
    """

    kind: str
    where: str
    number: int

    @classmethod
    def of(cls, text: str) -> Connection:
        """From what a command line says, as pymavlink and MAVSDK write it; udp: waits at its port, as theirs does.

        Raises
        ------
        DataFormatError         if it is none

        Examples
        --------
        >>> Connection.of("udp://:14550")
        Connection(kind='udpin', where='0.0.0.0', number=14550)
        >>> print(Connection.of("serial:/dev/ttyACM0"))
        serial:/dev/ttyACM0:57600
        """
        found = _URL.fullmatch(text.strip())
        if found is None:
            raise _wrong(text, KNOWN)
        kind, rest = _KINDS.get(found[1], found[1]), found[2]
        if kind == "serial":
            device, colon, number = rest.rpartition(":")
            device, number = (device, number) if colon else (number, str(USUAL_BAUD))
            if not device:
                raise _wrong(text, "expected a device, as serial:/dev/ttyACM0:57600")
            return cls(kind, device, _whole(text, number, "a baud rate", 4_000_000))
        host, _, number = rest.rpartition(":")
        host = host.removeprefix("[").removesuffix("]")
        if not host and kind != "udpin":
            raise _wrong(text, f"expected a host, as {found[1]}:127.0.0.1:14550")
        return cls(kind, host or "0.0.0.0", _whole(text, number, "a port", 65_535))

    def __str__(self) -> str:
        return f"{self.kind}:{self.where}:{self.number}"

    def opened(self) -> Channel:
        """The channel.

        Raises
        ------
        DataFormatError         if it cannot be opened
        """
        try:
            if self.kind == "serial":
                return _serial(self)
            return _tcp(self) if self.kind == "tcp" else _Datagrams(self)
        except OSError as error:
            came, expected = f"it cannot be opened: {error.strerror or error}", _advice(self.kind)
            raise DataFormatError(Fault("--connect", str(self), came, expected)) from None


def _whole(text: str, number: str, what: str, most: int) -> int:
    if not re.fullmatch("[0-9]{1,9}", number) or not 1 <= int(number) <= most:
        raise _wrong(text, f"expected {what} from 1 to {most}")
    return int(number)


def _wrong(text: str, expected: str) -> DataFormatError:
    return DataFormatError(Fault("--connect", "", f"{text[:200]!r} came", expected))


def _advice(kind: str) -> str:
    return {
        "udpin": "expected a free port of this machine: a ground station may hold it; let it forward to another port",
        "udpout": "expected a host that is known",
        "tcp": "expected a vehicle that listens there",
        "serial": "expected a radio or an autopilot at this device, and the right to use it",
    }[kind]


# ---------------------------------------------------------------- UDP


class _Datagrams:
    """UDP, at a port of our own or towards one of somebody else's."""

    whole = True

    def __init__(self, connection: Connection) -> None:
        found = socket.getaddrinfo(connection.where, connection.number, type=socket.SOCK_DGRAM)
        family, kind, protocol, _, address = found[0]
        self.socket = socket.socket(family, kind, protocol)
        self.others: dict[tuple[Any, ...], None] = {}
        try:
            if connection.kind == "udpin":
                self.socket.bind(address)
            else:
                self.others[address] = None
        except OSError:
            self.socket.close()
            raise
        self.socket.setblocking(False)

    def receive(self, seconds: float) -> tuple[bytes, Sender] | None:
        if not select.select([self.socket], [], [], max(seconds, 0.0))[0]:
            return None
        try:
            data, sender = self.socket.recvfrom(MOST_BYTES)
        except OSError:  # an answer that nobody listens there, or nothing after all
            return None
        if len(self.others) < 64:  # whoever floods the port is not remembered for ever
            self.others[sender] = None
        return data, sender

    def send(self, data: bytes, to: Sender) -> None:
        for address in list(self.others) if to is None else [to]:
            try:
                self.socket.sendto(data, address)
            except OSError:  # lost, as datagrams may be
                continue

    def close(self) -> None:
        self.socket.close()


# ---------------------------------------------------------------- TCP and serial lines


def _tcp(connection: Connection) -> Channel:
    """A connected socket."""
    line = socket.create_connection((connection.where, connection.number), CONNECT_S)
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    line.setblocking(False)
    return _Stream(line, line.recv, line.send, line.close)


class _Stream:
    """A line with one other end: what can be waited for, and how it is read, written and closed."""

    whole = False

    def __init__(
        self,
        line: socket.socket | int,
        read: Callable[[int], bytes],
        write: Callable[[bytes], int],
        close: Callable[[], None],
    ) -> None:
        self._line, self._read, self._write, self.close = line, read, write, close

    def receive(self, seconds: float) -> tuple[bytes, Sender] | None:
        if not select.select([self._line], [], [], max(seconds, 0.0))[0]:
            return None
        try:
            data = self._read(4096)
        except BlockingIOError:
            return None
        except OSError as error:
            raise _broken(error.strerror or str(error)) from None
        if not data:
            raise _broken("the other end closed it")
        return data, None

    def send(self, data: bytes, to: Sender) -> None:
        until = time.monotonic() + CONNECT_S
        while data:
            select.select([], [self._line], [], 1.0)
            try:
                data = data[self._write(data) :]
            except BlockingIOError:
                if time.monotonic() > until:
                    raise _broken("it takes no more bytes") from None
            except OSError as error:
                raise _broken(error.strerror or str(error)) from None


def _broken(came: str) -> DataFormatError:
    return DataFormatError(
        Fault("--connect", "", f"the connection broke: {came}", "expected one that lasts: try again")
    )


def _serial(connection: Connection) -> Channel:
    """A serial line, raw, at its baud rate."""
    if sys.platform == "win32":
        raise OSError(0, "serial lines are opened on Linux and macOS; here let a ground station forward to udp:")
    import termios
    import tty

    speed = getattr(termios, f"B{connection.number}", None)
    if speed is None:
        known = sorted(int(name[1:]) for name in dir(termios) if re.fullmatch("B[0-9]{4,}", name))
        raise OSError(0, f"baud {connection.number} is not one of {', '.join(map(str, known))}")
    line = os.open(connection.where, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        tty.setraw(line)
        told = termios.tcgetattr(line)
        told[4] = told[5] = speed
        termios.tcsetattr(line, termios.TCSANOW, told)
    except termios.error as error:
        os.close(line)
        raise OSError(0, f"it is no serial line: {error.args[-1]}") from None
    return _Stream(line, partial(os.read, line), partial(os.write, line), partial(os.close, line))
