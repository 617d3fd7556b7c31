"""The processor in another process, acted out by a short program."""

import sys

import pytest

from tests.support.robots.emulated_processor import CLOCK_HZ, EmulatedProcessor

ACTED = """
import struct, sys
cycle = 0
while head := sys.stdin.buffer.read(11):
    us, left, right, flags, count = struct.unpack("<IhhBH", head)
    data = sys.stdin.buffer.read(count)
    cycle += 16 * us
    answer = struct.pack("<BBBIIH", 255, 51, 5, (cycle - 16) % 2**32, cycle % 2**32, count)
    sys.stdout.buffer.write(answer + data)
    sys.stdout.buffer.flush()
"""


def test_its_time_goes_on_where_its_cycle_counter_wraps() -> None:
    processor = EmulatedProcessor([sys.executable, "-c", ACTED])
    for turn in range(1, 8):
        motors, data = processor.run(100.0, bytes([turn]))
        assert data == bytes([turn])
        assert motors.now_s == pytest.approx(100.0 * turn)
        assert motors.now_s - motors.off_s == pytest.approx(16 / CLOCK_HZ)
    processor.close()


def test_motors_turn_as_the_outputs_say() -> None:
    processor = EmulatedProcessor([sys.executable, "-c", ACTED])
    motors, _ = processor.run(0.001)
    assert motors.powered
    assert motors.left_m_s == pytest.approx(0.8)
    assert motors.right_m_s == pytest.approx(-0.16)
    processor.close()
