"""A vehicle that keeps missions, fences and rally points, in a thread on the loopback, with faults by script."""

import socket
import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from random import Random

from pymavlink.dialects.v20 import common

from sooner.io.mavlink import Patience

ARDUPILOT, PX4, GENERIC = 3, 12, 0
ALL_LISTS = common.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE | common.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
HASTE = Patience(10.0, neighbours_s=0.1, answer_s=0.3, silence_s=1.0, tries=6, busy_s=0.05, warnings_s=0.0)
AGAIN_S = 0.1


@dataclass(frozen=True)
class Script:
    """How a vehicle behaves."""

    autopilot: int = PX4
    systems: tuple[int, ...] = (1,)
    armed: bool = False
    arms_after: int | None = None  # requests
    capabilities: int | None = ALL_LISTS
    asks: str = "mission_request_int"
    asks_twice: bool = False
    loses: float = 0.0
    garbage: bool = False
    version_1: bool = False
    busy: int = 0  # times
    refuses: dict[int, int] = field(default_factory=dict)  # list -> MAV_MISSION_RESULT
    silent_after: int | None = None  # items taken
    forgets_acks: int = 0  # times
    keeps: Callable = lambda number, item: item
    held: dict[int, int] = field(default_factory=dict)  # list -> items of somebody else
    says: bytes = b""


class Vehicle(threading.Thread):
    """What it holds is in `lists`; `heard` counts messages by name."""

    def __init__(self, script: Script, ground: tuple[str, int] | None = None) -> None:
        super().__init__(daemon=True)
        self.script, self.random, self.ground = script, Random(7), ground
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.01)
        self.port = self.socket.getsockname()[1]
        self.speakers = [common.MAVLink(None, system, 1) for system in script.systems]
        self.lists = {kind: [_strange(n) for n in range(script.held.get(kind, 0))] for kind in (0, 1, 2)}
        self.heard: dict[str, int] = {}
        self.commands: list[int] = []
        self.taking = None  # list, items so far, how many
        self.asked_at, self.requests, self.taken = 0.0, 0, 0
        self.busy, self.forgets, self.armed = script.busy, script.forgets_acks, script.armed
        self.ended = threading.Event()

    def run(self) -> None:
        beat = 0.0
        while not self.ended.is_set():
            now = time.monotonic()
            if now > beat + 0.05:
                beat = now
                self._beat()
            if self.taking and now > self.asked_at + AGAIN_S:
                self._ask()
            try:
                data, self.ground = self.socket.recvfrom(65_535)
            except TimeoutError:
                continue
            self._take(data)
        self.socket.close()

    def _take(self, data: bytes) -> None:
        reader = common.MAVLink(None)
        reader.robust_parsing = True
        for message in reader.parse_buffer(data) or ():
            name = message.get_type()
            self.heard[name] = self.heard.get(name, 0) + 1
            if self.script.loses and self.random.random() < self.script.loses:
                continue
            if getattr(message, "target_system", 1) == self.script.systems[0]:
                getattr(self, f"_on_{name.lower()}", lambda message: None)(message)

    def _send(self, message, speaker: int = 0) -> None:
        if self.ground is None or self.silent:
            return
        if self.script.garbage:
            self.socket.sendto(self.random.randbytes(self.random.randrange(1, 300)), self.ground)
            self.socket.sendto(b"\xfd\xff\x00" + self.random.randbytes(40), self.ground)
        if self.script.loses and self.random.random() < self.script.loses:
            return
        packed = message.pack(self.speakers[speaker], force_mavlink1=self.script.version_1)
        self.socket.sendto(bytes(packed), self.ground)

    @property
    def silent(self) -> bool:
        return self.script.silent_after is not None and self.taken >= self.script.silent_after

    def _beat(self) -> None:
        for number in range(len(self.speakers)):
            mode = 128 if self.armed else 0
            self._send(common.MAVLink_heartbeat_message(2, self.script.autopilot, mode, 0, 3, 3), number)
        self._send(common.MAVLink_heartbeat_message(26, 8, 0, 0, 3, 3))  # its gimbal
        if self.script.says:
            self._send(common.MAVLink_statustext_message(3, self.script.says))

    # ------------------------------------------------------------ what it is told

    def _on_command_long(self, message) -> None:
        self.commands.append(message.command)
        if self.script.capabilities is not None and message.command == 512:
            told = self.script.capabilities, 0, 0, 0, 0, *[[0] * 8] * 3, 0, 0, 0
            self._send(common.MAVLink_autopilot_version_message(*told))

    def _on_mission_count(self, message) -> None:
        kind = message.mission_type
        if kind in self.script.refuses:
            self._acknowledge(kind, self.script.refuses[kind])
        elif self.busy:
            self.busy -= 1
            self._acknowledge(kind, 4)
        else:
            self.taking = kind, [], message.count
            self._ask()

    def _ask(self) -> None:
        kind, items, _ = self.taking
        self.asked_at, self.requests = time.monotonic(), self.requests + 1
        if self.requests == self.script.arms_after:
            self.armed = True
            self._beat()
        made = getattr(common, f"MAVLink_{self.script.asks}_message")
        for _ in range(1 + self.script.asks_twice):
            self._send(made(254, 190, len(items), kind))

    def _on_mission_item_int(self, message) -> None:
        if not self.taking or message.mission_type != self.taking[0]:
            return
        kind, items, count = self.taking
        if message.seq != len(items):
            self._acknowledge(kind, 13)
            return
        items.append(message)
        self.taken += 1
        if len(items) < count:
            self._ask()
            return
        self.lists[kind], self.taking = [self.script.keeps(n, item) for n, item in enumerate(items)], None
        if self.forgets:
            self.forgets -= 1
        else:
            self._acknowledge(kind, 0)

    def _on_mission_ack(self, message) -> None:
        if message.type == 15:
            self.taking = None

    def _on_mission_clear_all(self, message) -> None:
        self.lists[message.mission_type] = []
        self._acknowledge(message.mission_type, 0)

    def _on_mission_request_list(self, message) -> None:
        kind = message.mission_type
        if self.script.refuses.get(kind) == 3:
            self._acknowledge(kind, 3)
        else:
            self._send(common.MAVLink_mission_count_message(254, 190, len(self.lists[kind]), kind))

    def _on_mission_request_int(self, message) -> None:
        held = self.lists[message.mission_type][message.seq]
        told = [getattr(held, name) for name in held.fieldnames[2:-1]]
        self._send(common.MAVLink_mission_item_int_message(254, 190, *told, message.mission_type))

    def _acknowledge(self, kind: int, result: int) -> None:
        self._send(common.MAVLink_mission_ack_message(254, 190, result, kind))


def _strange(number: int):
    return common.MAVLink_mission_item_int_message(1, 1, number, 0, 16, 0, 1, 0, 0, 0, 0, 7, 7, 7)


def changed(item, **fields):
    """The same item but for some fields."""
    told = {name: getattr(item, name) for name in item.fieldnames} | fields
    return common.MAVLink_mission_item_int_message(**told)


def as_ardupilot_keeps(number: int, item):
    """Home is its own; centimetres are cut off; what has no place has no frame; what it chooses itself it tells."""
    if item.mission_type == 2:
        return changed(item, frame=6, z=float(int(item.z)))
    if item.mission_type == 1:
        return item
    if number == 0:
        return changed(item, x=460_000_100, y=110_000_100, z=312.0)
    if item.command in (20, 178):
        return changed(item, frame=0)
    chosen = {"param4": 1.0} if item.command == 21 else {"param1": float(int(item.param1))}
    return changed(item, z=int(item.z * 100) / 100, **chosen)


@contextmanager
def flying(script: Script | None = None, ground: tuple[str, int] | None = None, **changes):
    """A vehicle, while it is awake."""
    vehicle = Vehicle(replace(script or Script(), **changes), ground)
    vehicle.start()
    try:
        yield vehicle
    finally:
        vehicle.ended.set()
        vehicle.join(10)
        assert not vehicle.is_alive()
