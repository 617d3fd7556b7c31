"""What single drivers do with single bytes: wraps, damage, whole steps, other robots' words."""

from __future__ import annotations

import itertools
import json
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers.create2 import SETTLE_S, Create2Driver
from navigation.link.drivers.create2_wheel import NEVER, harmless
from navigation.link.drivers.drivers import DRIVERS
from navigation.link.drivers.epuck2 import Epuck2Driver
from navigation.link.drivers.turtlebot3 import Turtlebot3Driver, crc16
from navigation.link.drivers.waveshare import WaveshareDriver
from navigation.link.drivers.wheel_odometry import DOUBTS, WheelOdometry
from navigation.simulator.twins.create2 import DATA_BYTES, Create2Twin, OpenInterfaceMode


@given(st.integers(-500, 500))
def test_no_byte_of_a_speed_is_an_order_that_could_do_harm(speed: int) -> None:
    sent = harmless(speed)
    assert sent & 0xFF not in NEVER
    assert abs(sent - speed) <= 5
    assert (sent < 0) == (speed < 0) or sent == 0
    assert (sent == 0) == (speed == 0)


def test_what_a_lost_byte_makes_of_an_order_never_leaves_safe_mode() -> None:
    """Every byte of every order lost, and inverted; the next order is understood again."""
    for speed, position in itertools.product(range(-500, 501, 7), range(9)):
        driver, twin = Create2Driver(), Create2Twin()
        driver.open(0.0)
        greet(driver, twin)
        assert twin.mode is OpenInterfaceMode.SAFE
        driver.receive(frame_of(0, 0), 1.9)  # it answers: no greeting is due
        driver.drive(speed / 1000, -speed / 1000)
        order = bytearray(driver.bytes_to_send(2.0))
        del order[position]
        twin.receive(bytes(order), 2.0)
        assert twin.mode is not OpenInterfaceMode.OFF
        assert twin.mode is not OpenInterfaceMode.FULL
        driver.drive(0.1, 0.1)
        twin.receive(driver.bytes_to_send(2.1), 2.1)
        if twin.mode is OpenInterfaceMode.SAFE:
            assert twin.step(2.3, 0, 0)[:2] == pytest.approx((0.1, 0.1), abs=0.0285)


def greet(driver: Create2Driver, twin: Create2Twin) -> None:
    """Both bursts."""
    twin.receive(driver.bytes_to_send(0.0), 0.0)
    assert driver.bytes_to_send(SETTLE_S / 2) == b""
    twin.receive(driver.bytes_to_send(SETTLE_S), SETTLE_S)


def test_every_order_that_could_do_harm_is_known() -> None:
    harmful = {7, 129, 132, 133, 134, 135, 136, 137, 138, 143, 144, 146, 173}
    assert harmful <= NEVER
    assert harmful <= set(DATA_BYTES)


def frame_of(left: int, right: int) -> bytes:
    """A frame of the stream as the specification has it, with the driver's packets."""
    body = bytes([7, 0, 9, 0, 10, 0, 11, 0, 12, 0, 34, 0, 35, 2, 25, 8, 2, 26, 10, 136])
    body += bytes([43, *left.to_bytes(2, "big"), 44, *right.to_bytes(2, "big")])
    frame = bytes([19, len(body)]) + body
    return frame + bytes([-sum(frame) & 0xFF])


def test_encoder_counts_that_wrap_are_travel_and_no_jump() -> None:
    driver = Create2Driver()
    driver.open(0.0)
    greet(driver, Create2Twin())
    count, now_s = 65_500, 0.5
    for _ in range(40):
        driver.receive(frame_of(count % 65_536, -count % 65_536), now_s)
        driver.drive(0.15, -0.15)
        driver.bytes_to_send(now_s)
        count, now_s = count + 5, now_s + 0.015
    a_count = KNOWN_ROBOTS["create2"].metres_per_count
    assert a_count is not None
    assert driver.heard.left_m == pytest.approx(39 * 5 * a_count)
    assert driver.heard.right_m == pytest.approx(-39 * 5 * a_count)


@given(st.integers(0, 400), st.integers(0, 26), st.integers(0, 1_000_000))
def test_a_lost_byte_costs_a_frame_or_two_and_then_the_sum_is_found_again(
    begin: int, lost: int, seed: int
) -> None:
    rng = random.Random(seed)
    driver = Create2Driver()
    driver.open(0.0)
    frames = [bytearray(frame_of(begin + n, begin + n)) for n in range(8)]
    del frames[3][lost % len(frames[3])]
    driver.receive(bytes(rng.randrange(256) for _ in range(10)) + b"".join(frames), 0.5)
    assert driver.heard.messages >= 5
    a_count = KNOWN_ROBOTS["create2"].metres_per_count
    assert a_count is not None
    assert driver.heard.left_m <= 7 * a_count + 1e-9


def test_nonsense_counts_are_left_out_and_a_new_beginning_is_one() -> None:
    wheels = WheelOdometry(0.001, 0.5, None)
    assert wheels.count(100, 100, 0.0)
    assert wheels.count(101, 101, 0.02)
    assert not wheels.count(9_101, 102, 0.04)
    assert wheels.count(102, 102, 0.06)
    assert wheels.left_m == pytest.approx(0.002)
    for number in range(DOUBTS):
        taken = wheels.count(-5_000, -5_000, 0.08 + number / 50)
    assert taken
    assert wheels.count(-4_999, -5_000, 0.2)
    assert (wheels.left_m, wheels.right_m) == pytest.approx((0.003, 0.002))


def test_the_checks_of_protocol_2_are_those_of_its_manual() -> None:
    """The three examples of the protocol's manual: ping, read, write."""
    for packet in (
        "FF FF FD 00 01 03 00 01 19 4E",
        "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15",
        "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89",
    ):
        data = bytes.fromhex(packet)
        assert crc16(data[:-2]) == int.from_bytes(data[-2:], "little")


@pytest.mark.parametrize("speed_m_s", [0.004, 0.013, 0.057, -0.021, 0.2])
def test_a_turtlebot_drives_on_average_as_fast_as_it_should(speed_m_s: float) -> None:
    driver = Turtlebot3Driver()
    driver.open(0.0)
    driver.drive(speed_m_s, speed_m_s)
    steps = []
    for number in range(500):
        sent = driver.bytes_to_send(number * 0.021)
        steps.append(int.from_bytes(sent[10:14], "little", signed=True))
    assert sum(steps) / 500 / 100 == pytest.approx(speed_m_s, abs=2e-5)
    assert max(steps) - min(steps) <= 1
    driver.drive(0.0, 0.0)
    assert int.from_bytes(driver.bytes_to_send(99.0)[10:14], "little") == 0


def test_a_board_without_motors_is_a_fault() -> None:
    driver = Turtlebot3Driver()
    head = bytes.fromhex("FFFFFD00C805005500FF")
    driver.receive(head + crc16(head).to_bytes(2, "little"), 0.0)
    assert "its motors were not found" in str(driver.heard.fault)


def test_reports_that_come_together_share_the_time() -> None:
    """A stall on the line neither loses travel nor invents any."""
    line = json.dumps({"T": 1001, "L": 0.2, "R": 0.1, "v": 12.0}).encode() + b"\r\n"
    steady, bursts = WaveshareDriver(), WaveshareDriver()
    for number in range(1, 101):
        steady.receive(line, number * 0.01)
    bursts.receive(line, 0.01)
    for number in range(1, 12):
        bursts.receive(line * 9, 0.01 + number * 0.09)
    assert steady.heard.left_m == pytest.approx(0.198)
    assert bursts.heard.left_m == pytest.approx(0.198)
    assert bursts.heard.right_m == pytest.approx(0.099)


@pytest.mark.parametrize(
    "line",
    [
        b'{"T":1001,"L":1e9,"R":0}', b'{"T":1001,"L":"0.1","R":0}', b'{"T":1001,"R":0}',
        b'{"T":1001,"L":NaN,"R":0}', b'{"T":1001,"L":true,"R":0}', b"[1001]", b"{", b"\xff\xfe",
        b'{"T":1001,"L":0.1,"R":Infinity}', b"1001", b'{"T":1001.5,"L":0,"R":0}',
    ],
)  # fmt: skip
def test_what_is_no_report_moves_nothing(line: bytes) -> None:
    driver = WaveshareDriver()
    driver.receive(line + b"\n", 1.0)
    assert driver.heard.odometry_s is None
    assert driver.heard.identity is None


@pytest.mark.parametrize(
    ("name", "words", "stranger"),
    [
        ("epuck2", b'{"T":1001,"L":0,"R":0,"v":12.0}\r\n', "waveshare"),
        ("waveshare", b"v,Version 2.0 January 2018 GCtronic\r\n", "epuck2"),
    ],
)
def test_a_robot_that_is_recognised_is_named(name: str, words: bytes, stranger: str) -> None:
    driver = DRIVERS[name]()
    driver.receive(words, 0.0)
    assert driver.heard.stranger == stranger


def test_an_epuck_that_lost_a_digit_of_its_count_has_not_jumped() -> None:
    driver = Epuck2Driver()
    driver.receive(b"v,Version 2.0\r\nq,1234,1300\r\n", 0.0)
    driver.receive(b"q,134,1301\r\n", 0.02)
    driver.receive(b"q,1236,1302\r\n", 0.04)
    a_step = KNOWN_ROBOTS["epuck2"].metres_per_count
    assert a_step is not None
    assert driver.heard.left_m == pytest.approx(2 * a_step)
    assert driver.heard.damaged == 1


@pytest.mark.parametrize("name", tuple(DRIVERS))
@given(data=st.binary(max_size=400))
def test_no_bytes_make_a_driver_fall(name: str, data: bytes) -> None:
    driver = DRIVERS[name]()
    driver.open(0.0)
    driver.receive(data, 0.01)
    driver.receive(data[::-1], 0.02)
    driver.bytes_to_send(0.02)
    assert driver.heard.identity is None


@pytest.mark.parametrize("name", tuple(DRIVERS))
def test_a_stop_goes_out_at_once_and_again(name: str) -> None:
    driver = DRIVERS[name]()
    driver.open(0.0)
    now_s = 0.0
    sent: list[bytes] = []
    for tick in range(400):
        now_s = tick * 0.005
        driver.drive(*((0.1, 0.1) if tick < 300 else (0.0, 0.0)))
        sent.append(driver.bytes_to_send(now_s))
    after = b"".join(sent[300:])
    stops = {
        "create2": b"\x91\0\0\0\0",
        "turtlebot3": b"\x96\0" + bytes(24),
        "epuck2": b"D,0,0\r",
        "waveshare": b'{"T":1,"L":0.0,"R":0.0}',
    }
    assert stops[name] in b"".join(sent[300:305])
    assert after.count(stops[name]) >= 4
