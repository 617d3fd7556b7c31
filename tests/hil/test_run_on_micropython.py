"""A whole `clearway run` with the MicroPython robot, under the real MicroPython."""

from __future__ import annotations

from pathlib import Path

import pytest

import firmware_protocol.robot as package
from tests.support.robots.avr_bench import AvrBench
from tests.support.robots.emulated_processor import EmulatedProcessor
from tests.support.robots.emulated_run import assert_run_reaches_its_goal
from tests.support.robots.micropython_interpreter import interpreter

BRIDGE = Path(__file__).with_name("micropython_bridge.py")
pytestmark = pytest.mark.skipif(interpreter() is None, reason="needs MicroPython: .ci/micropython")


def command() -> list[str]:
    """A board with the robot's end on it, as ``EmulatedProcessor`` wants it."""
    found = interpreter()
    assert found is not None
    return [found, str(BRIDGE), str(Path(package.__file__).parent)]


@pytest.mark.timed  # the emulated processor has to keep up with the wall's clock
def test_clearway_run_drives_the_micropython_robot_to_its_goal(tmp_path: Path) -> None:
    assert_run_reaches_its_goal(tmp_path, command())


def test_the_emergency_stop_is_obeyed_in_the_round_that_reads_it() -> None:
    processor = EmulatedProcessor(command())
    bench = AvrBench(processor)
    bench.until(lambda: bench.host.state.is_up, 5.0)
    asked_s = bench.motors.now_s
    bench.host.estop()
    bench.run(0.1)
    assert bench.host.status is not None
    assert bench.host.status.state.name == "ESTOP"
    assert not bench.motors.powered
    assert bench.motors.now_s - asked_s < 0.11
    processor.close()
