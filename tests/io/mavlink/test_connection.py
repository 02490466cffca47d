"""Addresses of vehicles, and the lines behind them."""

import os
import select
import socket
import sys
import threading
import time
from contextlib import closing, contextmanager, suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.errors import DataFormatError
from sooner.io.mavlink import Connection, upload
from sooner.io.mavlink.link import Link
from tests.io.flights.plans import RIDGE
from tests.io.mavlink.scripted_vehicle import HASTE, flying


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("udp:127.0.0.1:14550", ("udpin", "127.0.0.1", 14550)),
        ("udp://:14540", ("udpin", "0.0.0.0", 14540)),
        ("udpin:0.0.0.0:14550", ("udpin", "0.0.0.0", 14550)),
        ("udpout:192.168.4.1:14550", ("udpout", "192.168.4.1", 14550)),
        ("tcp:localhost:5760", ("tcp", "localhost", 5760)),
        ("tcpout://[::1]:5760", ("tcp", "::1", 5760)),
        ("serial:/dev/ttyUSB0:921600", ("serial", "/dev/ttyUSB0", 921600)),
        ("serial:///dev/ttyUSB0:57600", ("serial", "/dev/ttyUSB0", 57600)),
        ("serial:/dev/ttyUSB0", ("serial", "/dev/ttyUSB0", 57600)),
    ],
)
def test_addresses_are_those_of_other_programs(text, found):
    connection = Connection.of(text)
    assert (connection.kind, connection.where, connection.number) == found
    assert Connection.of(str(connection)) == connection


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "expected udp:HOST:PORT"),
        ("127.0.0.1:14550", "expected udp:HOST:PORT"),
        ("/dev/ttyACM0", "expected udp:HOST:PORT"),
        ("flight.tlog", "expected udp:HOST:PORT"),
        ("http://127.0.0.1:80", "expected udp:HOST:PORT"),
        ("udp:127.0.0.1", "expected a port from 1 to 65535"),
        ("udp:127.0.0.1:0", "expected a port from 1 to 65535"),
        ("udp:127.0.0.1:65536", "expected a port from 1 to 65535"),
        ("udp:127.0.0.1:٣", "expected a port from 1 to 65535"),
        ("udp:127.0.0.1:" + "9" * 5_000, "expected a port from 1 to 65535"),
        ("udpout::14550", "expected a host"),
        ("tcp::14550", "expected a host"),
        ("serial:", "expected a device"),
        ("serial:/dev/ttyACM0:fast", "expected a baud rate"),
    ],
)
def test_an_address_that_is_none_is_refused(text, expected):
    with pytest.raises(DataFormatError) as refused:
        Connection.of(text)
    told = str(refused.value)
    assert told.startswith("--connect: ")
    assert expected in told
    assert len(told) < 500


@given(text=st.text(max_size=30) | st.text("udpinotcserial:/0123456789.[]", max_size=30))
def test_any_text_is_an_address_or_refused(text):
    with suppress(DataFormatError):
        Connection.of(text)


def test_what_cannot_be_opened_is_refused(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken, socket.socket() as deaf:
        taken.bind(("127.0.0.1", 0))
        deaf.bind(("127.0.0.1", 0))
        (tmp_path / "file").write_text("")
        for text, told in (
            (f"udp:127.0.0.1:{taken.getsockname()[1]}", "a ground station may hold it"),
            (f"tcp:127.0.0.1:{deaf.getsockname()[1]}", "expected a vehicle that listens there"),
            (f"serial:{tmp_path / 'none'}", "expected a radio or an autopilot"),
            (f"serial:{tmp_path / 'file'}", "it is no serial line"),
            (f"serial:{tmp_path / 'file'}:57601", "baud 57601 is not one of"),
        ):
            with pytest.raises(DataFormatError, match=told):
                Connection.of(text).opened()


def test_a_line_that_closes_is_told_of():
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        with closing(Connection.of(f"tcp:127.0.0.1:{server.getsockname()[1]}").opened()) as channel:
            server.accept()[0].close()
            with pytest.raises(DataFormatError, match="the connection broke"):
                channel.receive(10.0)


@contextmanager
def relayed(port: int, opened):
    """What comes in by one goes out by the other, in pieces that do not keep messages whole."""
    ended = threading.Event()

    def relay():
        descriptor = opened()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other, closing(os.fdopen(descriptor, "rb", 0)):
            other.connect(("127.0.0.1", port))
            while not ended.is_set():
                ready = select.select([other, descriptor], [], [], 0.01)[0]
                if descriptor in ready and not other.send(os.read(descriptor, 4096)):
                    return
                if other in ready:
                    data = other.recv(65_535)
                    for at in range(0, len(data), 7):
                        os.write(descriptor, data[at : at + 7])

    thread = threading.Thread(target=relay, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join(10)


def test_a_flight_goes_over_tcp():
    with flying() as vehicle, socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        with relayed(vehicle.port, lambda: server.accept()[0].detach()):
            address = Connection.of(f"tcp:127.0.0.1:{server.getsockname()[1]}")
            assert upload(RIDGE, address, patience=HASTE).same


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
@pytest.mark.parametrize("script", [{}, {"garbage": True, "capabilities": None}], ids=str)
def test_a_flight_goes_over_a_serial_line(script):
    near, far = os.openpty()
    with closing(os.fdopen(far, "rb", 0)), flying(**script) as vehicle, relayed(vehicle.port, lambda: near):
        assert upload(RIDGE, Connection.of(f"serial:{os.ttyname(far)}:57600"), patience=HASTE).same


class Heard:
    """A channel that gives what it was given."""

    def __init__(self, pieces, whole):
        self.pieces, self.whole = list(pieces), whole

    def receive(self, seconds):
        return (self.pieces.pop(0), None) if self.pieces else None

    def send(self, data, to):
        pass


@given(st.lists(st.binary(max_size=400) | st.binary(max_size=60).map(lambda data: b"\xfd" + data)), st.booleans())
def test_garbage_is_passed_over(pieces, whole):
    link = Link(Heard(pieces, whole))
    while link.receive(time.monotonic() + 0.002) is not None or link.channel.pieces:
        pass
