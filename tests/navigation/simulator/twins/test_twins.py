"""The twins against their vendors' documents: bytes that those print, and what they promise."""

from __future__ import annotations

import json
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.simulator.line_faults import FaultSpec, FaultSpecError
from navigation.simulator.twins.create2 import Create2Twin, OpenInterfaceMode
from navigation.simulator.twins.epuck2 import Epuck2Twin
from navigation.simulator.twins.kinds import TWINS, refuse_frame_faults
from navigation.simulator.twins.turtlebot3 import Turtlebot3Twin
from navigation.simulator.twins.twin import Twin
from navigation.simulator.twins.waveshare import WaveshareTwin


def said(twin: Twin, now_s: float = 0.0) -> bytes:
    """All that it has to say now."""
    out = b""
    while data := twin.bytes_to_send(now_s):
        out += data
    return out


# Create 2, by the examples and the tables of the Open Interface.


def started_create() -> Create2Twin:
    """In passive mode, and past the moment in which it is deaf."""
    twin = Create2Twin()
    twin.receive(bytes([128]), -1.0)
    return twin


def test_the_create_s_stream_is_the_specification_s_example() -> None:
    """[148][2][29][13] gives [19][5][29][hi][lo][13][0][sum], and all bytes add up to 0."""
    twin = started_create()
    twin.receive(bytes([148, 2, 29, 13]), 0.0)
    frame = said(twin, 0.015)
    assert (frame[0], frame[1], frame[2], frame[5]) == (19, 5, 29, 13)
    assert len(frame) == 8
    assert sum(frame) & 0xFF == 0
    assert said(twin, 0.020) == b"", "every 15 ms"
    assert len(said(twin, 0.031)) == 8


def test_a_create_that_is_off_hears_nothing_but_start() -> None:
    twin = Create2Twin()
    twin.receive(bytes([131, 145, 0, 100, 0, 100, 142, 35]), 0.0)
    assert (twin.mode, said(twin)) == (OpenInterfaceMode.OFF, b"")
    twin.receive(bytes([128, 131]), 0.0)
    assert twin.mode is OpenInterfaceMode.PASSIVE, "it is deaf while its mode changes"
    twin.receive(bytes([145, 0, 100, 0, 100]), 0.05)
    assert not twin.step(0.1, 0, 0).powered, "passive does not drive"
    twin.receive(bytes([131, 145, 0, 100, 255, 56]), 0.1)
    assert twin.step(0.1, 0, 0)[:2] == (-0.21, 0.1245), "right first, then left"
    twin.receive(bytes([142, 35]), 0.2)
    assert said(twin) == b"\x02"


def test_a_create_s_drive_by_radius_is_the_specification_s_example() -> None:
    """[137][255][56][1][244]: backwards at 200 mm/s on a circle of 500 mm."""
    twin = started_create()
    twin.receive(bytes([131, 137, 255, 56, 1, 244]), 0.0)
    left, right, _ = twin.step(0.0, 0, 0)
    assert (left + right) / 2 == pytest.approx(-0.2, abs=0.0285)
    assert (right - left) / 0.235 == pytest.approx(-0.2 / 0.5, abs=0.0285 / 0.235)


def test_a_create_s_counts_wrap_at_16_bits_and_go_the_way_that_was_ordered() -> None:
    twin = started_create()
    twin.receive(bytes([131, 145, 255, 156, 0, 100]), 0.0)
    twin.step(0.0, 0, 0)
    twin.step(0.1, 70_000, 5)
    twin.receive(bytes([149, 2, 43, 44]), 0.1)
    left, right = struct.unpack(">HH", said(twin))
    assert left == 70_000 % 65_536
    assert right == 65_536 - 5, "ordered backwards, pushed forwards: it counts down"
    twin.receive(bytes([145, 0, 0, 0, 0]), 0.1)
    twin.step(0.2, 70_000, 2)
    twin.receive(bytes([149, 1, 44]), 0.2)
    assert said(twin) == (65_536 - 5 + 3).to_bytes(2, "big"), "ordered to stand, it counts up"


@pytest.mark.parametrize(
    ("ordered", "driven"),
    [(0, 0), (10, 0), (11, 39), (25, 39), (39, 39), (40, 67.5), (67, 67.5), (68, 96),
     (467, 495), (496, 500), (500, 500)],
)  # fmt: skip
def test_a_create_drives_in_steps_as_its_owners_measured(ordered: int, driven: float) -> None:
    twin = started_create()
    twin.receive(bytes([131]) + struct.pack(">Bhh", 145, ordered, -ordered), 0.0)
    assert twin.step(0.0, 0, 0)[:2] == (-driven / 1000, driven / 1000)


def test_a_create_charges_in_passive_mode_only() -> None:
    twin = started_create()
    twin.dock(True)
    twin.receive(bytes([149, 2, 34, 21]), 0.0)
    assert said(twin) == bytes([2, 2])
    before = twin.charge_mah
    for second in range(3_601):
        twin.step(float(second), 0, 0)
        twin.receive(bytes([142, 21]), float(second))
    assert twin.charge_mah > before + 500
    full = twin.charge_mah
    twin.receive(bytes([131, 149, 1, 21]), 3_600.5)
    assert said(twin)[-1:] == b"\0"
    twin.step(3_700.0, 0, 0)
    assert (twin.charge_mah, twin.mode) == (full, OpenInterfaceMode.SAFE)
    twin.plug_in(True)
    twin.step(3_700.1, 0, 0)
    assert twin.mode is OpenInterfaceMode.PASSIVE


def test_a_create_that_was_reset_talks_for_three_seconds_and_has_forgotten_all() -> None:
    twin = started_create()
    twin.receive(bytes([131, 148, 1, 35]), 0.0)
    twin.receive(bytes([7]), 1.0)
    text = b"".join(said(twin, 1.0 + tick / 100) for tick in range(301))
    assert text.count(b"bl-start") == 3
    twin.receive(bytes([128]), 3.9)
    assert twin.mode is OpenInterfaceMode.OFF
    assert said(twin, 4.5) == b""
    twin.receive(bytes([128]), 4.5)
    assert twin.mode is OpenInterfaceMode.PASSIVE


def test_a_create_falls_asleep_in_passive_and_only_its_button_wakes_it() -> None:
    twin = Create2Twin()
    twin.receive(bytes([128]), 0.0)
    twin.step(299.0, 0, 0)
    assert not twin.asleep
    twin.step(300.5, 0, 0)
    assert twin.asleep
    twin.receive(bytes([128, 131]), 301.0)
    assert twin.mode is OpenInterfaceMode.OFF
    twin.press_clean(302.0)
    twin.receive(bytes([128]), 302.0)
    twin.receive(bytes([131]), 302.1)
    assert twin.mode is OpenInterfaceMode.SAFE


def test_a_lost_byte_makes_a_create_eat_the_next_order() -> None:
    twin = started_create()
    twin.receive(bytes([131, 145, 0, 100, 0]), 0.0)
    twin.receive(bytes([145, 0, 50, 0, 50]), 0.0)
    assert twin.step(0.0, 0, 0)[:2] == (0.153, 0.1245), "145 and 100 mm/s, to their steps"


def test_a_create_s_wheels_keep_the_last_order_for_ever() -> None:
    twin = started_create()
    twin.receive(bytes([131, 145, 0, 100, 0, 100]), 0.0)
    assert twin.step(3_000.0, 0, 0) == (0.1245, 0.1245, True)


# TurtleBot3, by the manual of protocol 2.0 and the board's control table.


def test_a_turtlebot_answers_a_ping_with_its_model() -> None:
    twin = Turtlebot3Twin()
    twin.receive(instruction(1, b""), 0.0)
    answer = said(twin)
    assert answer[:9] == bytes.fromhex("FFFFFD00C807005500")
    assert answer[9:11] == (0x5000).to_bytes(2, "little")
    assert slow_crc(answer[:-2]) == int.from_bytes(answer[-2:], "little")


def instruction(kind: int, data: bytes, board: int = 200) -> bytes:
    head = b"\xff\xff\xfd\x00" + bytes([board]) + (len(data) + 3).to_bytes(2, "little")
    head += bytes([kind]) + data
    return head + slow_crc(head).to_bytes(2, "little")


def slow_crc(data: bytes) -> int:
    """Long division, bit by bit: an oracle that shares nothing with driver or twin."""
    bits = [value >> shift & 1 for value in data for shift in range(7, -1, -1)] + [0] * 16
    divisor = [1, 1] + [0] * 12 + [1, 0, 1]  # x16 + x15 + x2 + 1
    for at in range(len(bits) - 16):
        if bits[at]:
            for offset, bit in enumerate(divisor):
                bits[at + offset] ^= bit
    return int("".join(map(str, bits[-16:])), 2)


def test_the_oracle_of_the_check_is_right_about_the_manual_s_examples() -> None:
    for packet in ("FFFFFD0001030001194E", "FFFFFD00010700028400 04001D15"):
        data = bytes.fromhex(packet)
        assert slow_crc(data[:-2]) == int.from_bytes(data[-2:], "little")


def test_a_turtlebot_stops_when_its_heartbeat_does_and_not_before() -> None:
    twin = Turtlebot3Twin()
    speeds = struct.pack("<H6i", 150, 10, 0, 0, 0, 0, 0)
    twin.receive(instruction(3, struct.pack("<HB", 19, 1)) + instruction(3, speeds), 0.0)
    for tick in range(1, 500):
        wheels = twin.step(tick / 1000, 0, 0)
    assert wheels.left_m_s == pytest.approx(0.1, abs=0.001)
    for tick in range(500, 560):
        wheels = twin.step(tick / 1000, 0, 0)
    assert wheels[:2] == (0.0, 0.0)


def test_a_turtlebot_refuses_what_may_not_be_written_and_ignores_a_wrong_check() -> None:
    twin = Turtlebot3Twin()
    twin.receive(instruction(3, struct.pack("<HI", 136, 7)), 0.0)
    assert said(twin)[8] == 7, "access error"
    damaged = bytearray(instruction(1, b""))
    damaged[-1] ^= 1
    twin.receive(bytes(damaged) + instruction(1, b"", board=3), 0.0)
    assert said(twin) == b""
    twin.receive(b"\xff\xff" + instruction(1, b""), 0.0)
    assert len(said(twin)) == 14


def test_a_turtlebot_s_table_is_20_ms_old_at_most() -> None:
    twin = Turtlebot3Twin()
    twin.step(0.030, 4_096, -5)
    twin.receive(instruction(2, struct.pack("<HH", 136, 8)), 0.031)
    assert struct.unpack("<ii", said(twin)[9:17]) == (4_096, -5)
    twin.step(0.040, 5_000, 0)
    twin.receive(instruction(2, struct.pack("<HH", 136, 4)), 0.041)
    assert struct.unpack("<i", said(twin)[9:13]) == (4_096,)


def read_byte(twin: Turtlebot3Twin, address: int) -> int:
    twin.receive(instruction(2, struct.pack("<HH", address, 1)), 0.0)
    return said(twin)[9]


def test_a_turtlebot_looks_for_its_motors_when_it_starts_and_never_again() -> None:
    twin = Turtlebot3Twin()
    assert (read_byte(twin, 18), read_byte(twin, 149)) == (0, 1)
    twin.power_motors(False)
    twin.boot(1.0)
    twin.power_motors(True)
    twin.receive(instruction(3, struct.pack("<HB", 149, 1)), 1.1)
    twin.step(1.2, 9, 9)
    said(twin)
    assert read_byte(twin, 18) == 0xFF
    assert not twin.step(1.3, 9, 9).powered
    assert read_byte(twin, 136) == 0, "nor does it read their travel"
    twin.boot(2.0)
    assert (read_byte(twin, 18), read_byte(twin, 149)) == (0, 1)


def test_a_turtlebot_s_motors_wake_without_torque_and_take_it_from_register_149() -> None:
    twin = Turtlebot3Twin()
    twin.power_motors(False)
    twin.power_motors(True)
    assert not twin.step(0.1, 0, 0).powered
    assert (read_byte(twin, 18), read_byte(twin, 149)) == (0, 0)
    twin.receive(instruction(3, struct.pack("<HB", 149, 1)), 0.2)
    said(twin)
    assert twin.step(0.3, 0, 0).powered
    assert read_byte(twin, 149) == 1


# e-puck2, by its handler's answers.


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        (b"D,100,-50\r", b"d\r\n"), (b"d,1,1\n", b"d\r\n"), (b"S\r", b"s\r\n"),
        (b"E\r", b"e,0,0\r\n"), (b"x\r", b"z,Command not found\r\n"), (b"\r\n\0Q\r", b"q,7,-3\r\n"),
    ],
)  # fmt: skip
def test_an_epuck_answers_each_line(line: bytes, answer: bytes) -> None:
    twin = Epuck2Twin()
    assert b"WELCOME" in said(twin)
    twin.step(0.0, 7, -3)
    twin.receive(line, 0.0)
    assert said(twin) == answer


def test_an_epuck_keeps_what_it_cannot_read_and_drives_for_ever() -> None:
    twin = Epuck2Twin()
    twin.receive(b"D,500,250\rD,x,y\rD,40\r", 0.0)
    left, right, powered = twin.step(1e4, 0, 0)
    assert powered
    assert left == pytest.approx(40 * 0.0001288, rel=1e-3)
    assert right == pytest.approx(250 * 0.0001288, rel=1e-3)


def test_an_epuck_in_its_binary_mode_hears_no_text_until_a_zero_comes() -> None:
    twin = Epuck2Twin()
    said(twin)
    twin.receive(b"\xc4,1,1\rQ\rV\r", 0.0)
    assert said(twin) == b""
    twin.receive(b"\0Q\r", 0.0)
    assert said(twin) == b"q,0,0\r\n"


# Waveshare, by its list of commands.


UGV01 = b'{"T":900,"main":3,"module":0}\n'


def ugv01() -> WaveshareTwin:
    """It has been told which robot it is."""
    twin = WaveshareTwin()
    twin.receive(UGV01, 0.0)
    said(twin)
    return twin


def test_a_waveshare_echoes_reports_and_stops_as_its_commands_say() -> None:
    twin = ugv01()
    twin.receive(b'{"T":131,"cmd":1}\n', 0.0)
    assert said(twin) == b'{"T":131,"cmd":1}\n'
    twin.receive(b'{"T":143,"cmd":0}\n{"T":1,"L":0.2,"R":0.1}\n', 0.0)
    said(twin)
    wheels = twin.step(0.01, 0, 0)
    assert wheels == (0.2, 0.1, True)
    report = json.loads(said(twin))
    assert (report["T"], report["y"]) == (1001, "null")
    assert twin.step(2.9, 0, 0)[:2] == (0.2, 0.1)
    assert twin.step(3.1, 0, 0)[:2] == (0.0, 0.0), "3 s without an order"
    twin.receive(b'{"T":136,"cmd":500}\n{"T":13,"X":0.1,"Z":1.0}\n', 4.0)
    assert twin.step(4.4, 0, 0)[:2] == pytest.approx((0.1 - 0.0705, 0.1 + 0.0705))
    assert twin.step(4.6, 0, 0)[:2] == (0.0, 0.0)


def test_a_waveshare_s_speeds_are_whole_pulses_over_its_loop() -> None:
    twin = ugv01()
    twin.receive(b'{"T":143,"cmd":0}\n', 0.0)
    twin.step(0.01, 0, 0)
    twin.step(0.02, 3, -1)
    twin.receive(b'{"T":130}\n', 0.02)
    report = json.loads(said(twin).splitlines()[-1])
    pulse_m = 3.14159265 * 0.0523 / 1092
    assert report["L"] == pytest.approx(3 * pulse_m / 0.01, rel=1e-6)
    assert report["R"] == pytest.approx(-pulse_m / 0.01, rel=1e-6)


@pytest.mark.parametrize(
    "line",
    [
        b"{",
        b"[1]",
        b'{"T":1,"L":"0.3","R":0.3}',
        b'{"T":1,"L":0.3}',
        b'{"T":1,"L":9,"R":0}',
        b"\xff",
    ],
)
def test_a_waveshare_ignores_what_is_no_order(line: bytes) -> None:
    twin = ugv01()
    twin.receive(line + b"\n", 0.0)
    assert twin.step(0.01, 0, 0)[:2] == (0.0, 0.0)


def test_a_waveshare_that_has_started_is_another_robot_until_it_is_told() -> None:
    """By type 1 the speed is a share of the power, and the motors turn the other way."""
    twin = ugv01()
    twin.boot(10.0)
    twin.receive(b'{"T":143,"cmd":0}\n', 10.0)
    assert b"Initialize" in said(twin, 10.0)
    assert not twin.step(11.9, 0, 0).powered
    twin.receive(b'{"T":1,"L":0.1,"R":0.25}\n', 12.1)
    left, right, _ = twin.step(12.2, 0, 0)
    assert left == pytest.approx(-0.35 * 0.1 * 512 / 255)
    assert right == pytest.approx(-0.35 * 0.25 * 512 / 255)
    twin.receive(UGV01 + b'{"T":1,"L":0.1,"R":0.25}\n', 12.3)
    assert twin.step(12.4, 0, 0)[:2] == (0.1, 0.25)


def test_a_waveshare_with_the_firmware_for_ros_reports_hundredths_of_a_volt() -> None:
    twin = WaveshareTwin(is_for_ros=True)
    twin.step(0.0, 0, 0)
    assert json.loads(said(twin))["v"] == 1190
    assert twin.main_type == 2


def test_a_waveshare_without_encoders_counts_nothing_and_goes_to_full_power() -> None:
    twin = WaveshareTwin(has_encoders=False)
    twin.receive(b'{"T":143,"cmd":0}\n' + UGV01 + b'{"T":1,"L":0.01,"R":-0.01}\n', 0.0)
    assert twin.step(0.1, 0, 0)[:2] == (0.35, -0.35)
    twin.step(0.2, 500, 500)
    twin.receive(b'{"T":130}\n', 0.2)
    report = json.loads(said(twin).splitlines()[-1])
    assert (report["L"], report["R"]) == (0.0, 0.0)


# All.


@pytest.mark.parametrize("kind", tuple(TWINS))
@given(data=st.binary(max_size=300), cut=st.integers(0, 300))
def test_no_bytes_make_a_twin_fall_and_portions_make_no_difference(
    kind: str, data: bytes, cut: int
) -> None:
    whole, parts = TWINS[kind](), TWINS[kind]()
    whole.receive(data, 0.0)
    parts.receive(data[:cut], 0.0)
    parts.receive(data[cut:], 0.0)
    assert whole.step(0.001, 1, 1) == parts.step(0.001, 1, 1)
    assert whole.bytes_to_send(0.0) == parts.bytes_to_send(0.0)


@pytest.mark.parametrize("fault", ["dup=0.1", "swap=0.1", "span=0.1"])
def test_faults_of_our_own_frames_are_refused_for_other_lines(fault: str) -> None:
    with pytest.raises(FaultSpecError, match="about the frames of Clearway's own line"):
        refuse_frame_faults(FaultSpec.parse(fault))
