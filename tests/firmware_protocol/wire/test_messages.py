import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.wire.errors import LocalError, RemoteError
from firmware_protocol.wire.framing import MAX_PAYLOAD, FrameParser, Sender, WireFrame
from firmware_protocol.wire.messages import (
    ESTOP_FRAME,
    MESSAGES,
    WAYPOINTS_PER_FRAME,
    Lease,
    LeaseFlag,
    MessageType,
    PoseFix,
    Waypoint,
    WaypointFlag,
    Waypoints,
    read_message,
    wrap_angle,
)
from firmware_protocol.wire.mission import Mission, mission_seed
from tests.support.wire import protocol_vectors

ANGLES = st.floats(-1000.0, 1000.0)
POSITIONS = st.floats(-2147.0, 2147.0)
WAYPOINTS = st.builds(
    Waypoint,
    x_m=POSITIONS,
    y_m=POSITIONS,
    speed_m_s=st.floats(0.0, 65.0),
    heading_rad=st.none() | ANGLES,
    acceptance_m=st.floats(0.0, 6.5),
    dwell_s=st.floats(0.0, 25.5),
    flags=st.sampled_from([WaypointFlag(v) for v in range(4)]),
)


@pytest.mark.parametrize(("name", "sender", "message"), protocol_vectors.MESSAGES)
def test_message_survives_packing(name: str, sender: Sender, message: object) -> None:
    packed = message.pack()  # type: ignore[attr-defined]
    again = type(message).unpack(packed)  # type: ignore[attr-defined]
    assert again.pack() == packed
    assert len(packed) <= MAX_PAYLOAD


@given(WAYPOINTS)
def test_waypoint_is_exact_to_half_a_unit_of_the_wire(waypoint: Waypoint) -> None:
    again = Waypoint.unpack(waypoint.pack())
    assert abs(again.x_m - waypoint.x_m) <= 0.51e-6
    assert abs(again.y_m - waypoint.y_m) <= 0.51e-6
    assert abs(again.speed_m_s - waypoint.speed_m_s) <= 0.51e-3
    assert abs(again.acceptance_m - waypoint.acceptance_m) <= 0.51e-4
    assert abs(again.dwell_s - waypoint.dwell_s) <= 0.051
    assert (again.heading_rad is None) == (waypoint.heading_rad is None)
    if again.heading_rad is not None and waypoint.heading_rad is not None:
        off = math.remainder(again.heading_rad - waypoint.heading_rad, math.tau)
        assert abs(off) < 1e-4
    assert again.pack() == waypoint.pack()


@given(st.binary(max_size=MAX_PAYLOAD), st.integers(0, 255))
def test_any_payload_is_read_or_refused(payload: bytes, kind: int) -> None:
    try:
        message = read_message(WireFrame(kind, 0, payload))
    except RemoteError:
        return
    assert message.pack() == payload or isinstance(message, Waypoints)


@pytest.mark.parametrize("kind", sorted(MESSAGES))
def test_a_message_one_byte_too_short_or_long_is_refused(kind: MessageType) -> None:
    packed = next(m.pack() for _, _, m in protocol_vectors.MESSAGES if kind == m.TYPE)
    for wrong in (packed[:-1], packed + b"\0"):
        with pytest.raises(RemoteError):
            MESSAGES[kind].unpack(wrong)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("x_m", 2147.5),
        ("y_m", -3000.0),
        ("x_m", math.nan),
        ("speed_m_s", -0.1),
        ("speed_m_s", 66.0),
        ("heading_rad", math.inf),
        ("acceptance_m", 7.0),
        ("dwell_s", 26.0),
        ("dwell_s", -1.0),
    ],
)
def test_waypoint_out_of_range_is_refused_with_its_limit(field: str, value: float) -> None:
    waypoint = replace(Waypoint(0.0, 0.0, 0.0), **{field: value})
    with pytest.raises(LocalError, match=field):
        waypoint.pack()


@pytest.mark.parametrize("count", [0, WAYPOINTS_PER_FRAME + 1])
def test_a_frame_of_none_or_too_many_waypoints_is_refused(count: int) -> None:
    with pytest.raises(LocalError):
        Waypoints(1, 0, (bytes(16),) * count).pack()


@pytest.mark.parametrize("count", [0, 7, 255])
def test_a_count_that_lies_is_refused(count: int) -> None:
    with pytest.raises(RemoteError):
        Waypoints.unpack(bytes(8) + bytes([count, 0]) + bytes(16))


def test_unknown_flags_and_headings_are_refused() -> None:
    good = Waypoint(0.0, 0.0, 0.0).pack()
    with pytest.raises(RemoteError):
        Waypoint.unpack(good[:-1] + b"\x04")
    with pytest.raises(RemoteError):
        Waypoint.unpack(good[:8] + (31_417).to_bytes(2, "little") + good[10:])
    with pytest.raises(RemoteError):
        Lease.unpack(bytes(8) + b"\x04")
    with pytest.raises(RemoteError):
        PoseFix.unpack(bytes(8) + (-32768).to_bytes(2, "little", signed=True) + bytes(4))


def test_an_infinite_pose_age_means_no_pose() -> None:
    lease = Lease(0.5, LeaseFlag.PERMIT)
    assert Lease.unpack(lease.pack()) == lease
    assert Lease.unpack(replace(lease, pose_age_s=100.0).pack()).pose_age_s == math.inf
    with pytest.raises(LocalError):
        Lease(-0.1, LeaseFlag.NONE).pack()
    with pytest.raises(LocalError):
        Lease(math.nan, LeaseFlag.NONE).pack()


@given(ANGLES)
def test_wrapped_angles_are_the_same_angle(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.isclose(math.cos(wrapped), math.cos(angle), abs_tol=1e-9)
    assert math.isclose(math.sin(wrapped), math.sin(angle), abs_tol=1e-9)


def test_the_emergency_stop_is_one_constant_frame() -> None:
    assert len(ESTOP_FRAME) == 15
    (frame,) = FrameParser(Sender.HOST).feed(ESTOP_FRAME)
    assert frame == WireFrame(MessageType.ESTOP, 0)


def test_prefix_crcs_tell_order_and_mission_apart() -> None:
    a, b = Waypoint(0.1, 0.0, 0.1), Waypoint(0.2, 0.0, 0.1)
    last = Waypoint(0.3, 0.0, 0.0)
    one, other = Mission(1, [a, b, last]), Mission(1, [b, a, last])
    assert one.prefix_crc(0) == other.prefix_crc(0) == mission_seed(1)
    assert one.prefix_crc(2) != other.prefix_crc(2)
    assert Mission(2, [a]).prefix_crc(0) != one.prefix_crc(0)
    assert one.prefix_crc(4) is None
    assert one.records[-1][-1] == WaypointFlag.END


def test_an_empty_mission_and_a_bad_id_are_refused() -> None:
    with pytest.raises(LocalError):
        Mission(1, [])
    for bad in (0, 1 << 32, -1):
        with pytest.raises(LocalError):
            Mission(bad, [Waypoint(0.0, 0.0, 0.0)])
