"""A whole `clearway run` with the AVR binary as the robot, in real time.

Camera, vision, planning, the link and the pseudo-terminal are those of every run; behind the
line an emulated ATmega328P runs the firmware, and its PWM and encoders move the drive model.
"""

from __future__ import annotations

import random
import resource
from pathlib import Path

import numpy as np
import pytest
import serial

from firmware_protocol.host.connection import HostConnection
from navigation.simulator.line_faults import FaultSpec
from navigation.simulator.robot import SimulatedRobot
from navigation.simulator.twins.twin import STEP_S
from tests.support.robots.avr_robot import AvrRobot, missing_tools
from tests.support.robots.emulated_processor import EmulatedProcessor, EmulatorError
from tests.support.robots.emulated_run import assert_run_reaches_its_goal
from tests.support.robots.emulated_twin import EmulatedTwin

pytestmark = pytest.mark.skipif(missing_tools() is not None, reason=f"needs {missing_tools()}")


def speed_of_emulation(avr: AvrRobot) -> float:
    """Emulated seconds in a second of the processor's time, whatever else it does meanwhile."""
    before_s = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    processor = EmulatedProcessor(avr.command)
    processor.run(1.0)
    processor.close()
    return 1.0 / (resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before_s)


@pytest.mark.timed  # the emulated processor has to keep up with the wall's clock
def test_clearway_run_drives_the_emulated_microcontroller_to_its_goal(tmp_path: Path) -> None:
    with AvrRobot() as avr:
        speed = speed_of_emulation(avr)
        if speed < 1.0:
            pytest.skip(f"this machine emulates {speed:.2f} seconds in a second: not real time")
        assert_run_reaches_its_goal(tmp_path, avr.command)


@pytest.mark.parametrize(("faults", "boots"), [("", 1), ("reset=0.5", 2), ("freeze=0.6@0.5", 1)])
def test_the_emulated_robot_obeys_reset_and_freeze(faults: str, boots: int) -> None:
    """Told by the boot ids that a host sees, and by how long it sees nothing."""
    rng, clock = np.random.default_rng(1), Clock()
    with AvrRobot() as avr:
        twin, spec = EmulatedTwin(avr.command), FaultSpec.parse(faults)
        robot = SimulatedRobot(twin=twin, rng=rng, faults=spec, clock=clock)
        host = HostConnection(random.Random(1))
        with serial.Serial(robot.port, timeout=0) as port:
            seen, silent_s = watch(robot, host, port, clock)
        robot.stop()
        twin.close()
    assert len(seen) == boots
    assert (silent_s > 0.55) == faults.startswith("freeze")


class Clock:
    """Virtual time."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def watch(
    robot: SimulatedRobot, host: HostConnection, port: serial.Serial, clock: Clock
) -> tuple[set[int], float]:
    """Two seconds: the boot ids in STATUS, and the longest time without a byte."""
    seen: set[int] = set()
    heard_s = silent_s = 0.0
    host.open(0.0)
    robot.switched_on()
    while clock.now_s < 2.0:
        clock.now_s += STEP_S
        robot.turn()
        data = port.read(4096)
        if data:
            heard_s = clock.now_s
        silent_s = max(silent_s, clock.now_s - heard_s)
        host.receive_bytes(data, clock.now_s)
        host.tick(clock.now_s)
        port.write(host.bytes_to_send(clock.now_s))
        if host.status is not None:
            seen.add(host.status.boot_id)
    return seen, silent_s


def test_an_emulator_that_ends_is_an_error_and_no_hang() -> None:
    processor = EmulatedProcessor(["true"])
    with pytest.raises(EmulatorError, match="has ended"):
        processor.run(0.001)
    processor.close()
    with pytest.raises(EmulatorError, match="no-such-program"):
        EmulatedTwin(["no-such-program"])
