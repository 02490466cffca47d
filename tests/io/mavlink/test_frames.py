"""Messages are found whatever stands between them."""

from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from sooner.io.mavlink.frames import messages

SPEAKER = common.MAVLink(None, 3, 1)
FRAMES = [
    bytes(common.MAVLink_mission_request_int_message(254, 190, 7, 1).pack(SPEAKER)),
    bytes(common.MAVLink_heartbeat_message(2, 3, 0, 0, 3, 3).pack(SPEAKER, force_mavlink1=True)),
    bytes(common.MAVLink_mission_ack_message(254, 190, 0, 2).pack(SPEAKER)),
]
NAMES = ["MISSION_REQUEST_INT", "HEARTBEAT", "MISSION_ACK"]
MARKS = bytes([0xFD, 0xFE])
GARBAGE = st.binary(max_size=40) | st.sampled_from(
    [b"\xfd\xff\x00", b"\xfd\x05\x00\x00", FRAMES[0][:9], FRAMES[1][:-1]]
)


def names(pieces, whole):
    buffer, found = bytearray(), []
    for piece in pieces:
        buffer += piece
        found += [message.get_type() for message in messages(common, SPEAKER, buffer, whole)]
    return found


@given(st.lists(GARBAGE, min_size=4, max_size=4))
def test_garbage_in_a_datagram_hides_no_message(garbage):
    data = b"".join(part for pair in zip(garbage, [*FRAMES, b""], strict=True) for part in pair)
    assert [name for name in names([data], whole=True) if name in NAMES] == NAMES


@given(st.lists(GARBAGE, min_size=4, max_size=4), st.integers(1, 50))
def test_garbage_on_a_line_hides_no_message_for_long(garbage, size):
    data = b"".join(part for pair in zip(garbage, [*FRAMES, bytes(300)], strict=True) for part in pair)
    pieces = [data[at : at + size] for at in range(0, len(data), size)]
    assert [name for name in names(pieces, whole=False) if name in NAMES] == NAMES


@given(st.lists(st.binary(max_size=400)))
def test_what_is_kept_for_later_is_short(pieces):
    buffer = bytearray()
    for piece in pieces:
        buffer += piece
        list(messages(common, SPEAKER, buffer, whole=False))
        assert len(buffer) < 300
