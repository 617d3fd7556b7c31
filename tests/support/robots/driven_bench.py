"""A robot behind its driver in virtual time: host, wire, driver, vendor's line, twin, wheels.

Everything of a run but its processes and its pictures. A second takes about a tenth of one.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field, replace

import numpy as np

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.robot.connection import Identity
from firmware_protocol.robot.controller import WheelSpeeds
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.messages import RobotState, Waypoint, WaypointFlag
from firmware_protocol.wire.mission import Mission
from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers.driven_robot import DrivenRobot
from navigation.link.drivers.drivers import new_driver
from navigation.simulator.drive_model import Drive, DriveModel, TruePose
from navigation.simulator.line_faults import FaultSpec, FaultyLine
from navigation.simulator.twins.kinds import TWINS, wheels_of
from navigation.simulator.twins.twin import ON_FOR_S, Twin
from navigation.simulator.virtual_loop import PacedLine

TICK_S = 0.001
TICKS_A_FIX = 33
TICKS_A_LEASE = 100
PORT = "/dev/ttyUSB0"


def settings_of(name: str) -> DriveSettings:
    """Limits that each of the robots keeps."""
    known = KNOWN_ROBOTS[name]
    return DriveSettings(
        track_m=known.track_m,
        max_speed_m_s=0.8 * known.speed_m_s,
        max_turn_rad_s=0.4 * known.turn_rad_s,
        turn_acceleration_rad_s2=known.turn_acceleration_rad_s2,
        least_wheel_m_s=known.least_wheel_m_s,
    )


@dataclass
class DrivenBench:
    """``speaks``: what is really on the port; ``driver`` which driver is asked to drive it."""

    driver: str
    speaks: str | None = None
    seed: int = 1
    faults: FaultSpec = field(default_factory=FaultSpec)
    baud: int | None = None
    slip: float = 0.01
    lag_s: float = 0.05
    twin: Twin = field(default=None)  # type: ignore[assignment]
    """Another one than the ordinary of its kind."""
    model: str | None = None
    """As ``robot.model``."""
    dead_zone_m_s: float = 0.005
    least_wheel_m_s: float | None = None
    """As ``robot.least_wheel_m_s``."""

    def __post_init__(self) -> None:
        self.speaks = self.speaks or self.driver
        self.known = KNOWN_ROBOTS[self.driver]
        rng = np.random.default_rng(self.seed)
        self.twin = self.twin or TWINS[self.speaks]()
        model = DriveModel(
            track_m=self.twin.body.track_m * 1.01,
            lag_s=self.lag_s,
            left_scale=1.005,
            slip=self.slip,
            dead_zone_m_s=self.dead_zone_m_s,
        )
        self.drive = Drive(wheels_of(self.twin, model), TruePose(0.0, 0.0, 0.0), rng)
        self.ticks_per_m = self.twin.body.ticks_per_m
        self.baud = self.baud or self.known.baud
        settings = replace(settings_of(self.driver), track_m=self.twin.body.track_m)
        if self.least_wheel_m_s is not None:
            settings = replace(settings, least_wheel_m_s=self.least_wheel_m_s)
        self.robot = DrivenRobot(
            new_driver(self.driver, self.model),
            settings,
            Identity(77),
            PORT,
            self.baud,
        )
        self.host = HostConnection(random.Random(self.seed), 1_000_000)
        self.to_robot, self.to_driver = PacedLine(self.twin.baud), PacedLine(self.twin.baud)
        self.lines = (FaultyLine(self.faults, rng), FaultyLine(self.faults, rng))
        self.now_s = 0.0
        self.ticks = 0
        self.plugged = self.leases = self.driver_lives = self.switched_on = True
        self.wheels = WheelSpeeds(0.0, 0.0, powered=False)
        self.zero = (0, 0)
        self.off_track_m = 0.0
        self.host.open(0.0)
        self.robot.port_opened(0.0)
        self.twin.boot(-ON_FOR_S)

    # What a person does.

    def reboot(self) -> None:
        """The robot's processor starts again: counts at zero."""
        left, right = self._ticks()
        self.zero = (self.zero[0] + left, self.zero[1] + right)
        self.twin.boot(self.now_s)

    # Time.

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK_S)):
            self.tick()

    def tick(self) -> None:
        self.ticks += 1
        self.now_s += TICK_S
        now_s = self.now_s
        self._move_bytes()
        if self.switched_on and self.ticks % 2 == 0:
            self.wheels = self.twin.step(now_s, *self._ticks())
        self.drive.step(
            TICK_S, self.wheels if self.switched_on else self.wheels._replace(powered=False)
        )
        if self.ticks % TICKS_A_FIX == 0:
            self.host.pose_fix(*self.drive.pose, now_s)
        if self.leases and self.ticks % TICKS_A_LEASE == 0:
            self.host.lease(now_s, 0.5, True, 0.01)
        self.host.tick(now_s)
        while self.host.next_event() is not None:
            pass

    def _move_bytes(self) -> None:
        now_s = self.now_s
        arrived = self.lines[0].carry(self.to_robot.take(now_s), now_s)
        if arrived and self.plugged and self.switched_on:
            self.twin.receive(arrived, now_s)
        if self.switched_on and self.to_driver.free(now_s):
            self.to_driver.put(self.twin.bytes_to_send(now_s), now_s)
        arrived = self.lines[1].carry(self.to_driver.take(now_s), now_s)
        if not self.driver_lives or self.ticks % 5:
            self._kept = getattr(self, "_kept", b"") + (arrived if self.plugged else b"")
            return
        arrived = getattr(self, "_kept", b"") + (arrived if self.plugged else b"")
        self._kept = b""
        if arrived:
            self.robot.receive_from_robot(arrived, now_s)
        self.robot.receive_from_host(self.host.bytes_to_send(now_s), now_s)
        self.robot.tick(now_s)
        if self.to_robot.free(now_s):
            self.to_robot.put(self.robot.bytes_to_robot(now_s), now_s)
        self.host.receive_bytes(self.robot.bytes_to_host(now_s), now_s)

    def _ticks(self) -> tuple[int, int]:
        left_m, right_m = self.drive.encoders_m
        left, right = round(left_m * self.ticks_per_m), round(right_m * self.ticks_per_m)
        return left - self.zero[0], right - self.zero[1]

    # A mission.

    def get_ready(self) -> None:
        """Until the host may drive."""
        self.run_until(lambda: self.host.clock.ready and self.host.status is not None, 4.0)

    def run_until(self, holds, seconds: float) -> None:  # type: ignore[no-untyped-def]
        end_s = self.now_s + seconds
        while not holds():
            assert self.now_s < end_s, f"not within {seconds} s: {self.robot.word(self.now_s)}"
            self.tick()

    def send(self, mission: int, *places: tuple[float, float]) -> None:
        """Drive through these, and stop at the last with heading 0."""
        speed = 0.6 * self.known.speed_m_s
        points = [Waypoint(x, y, speed) for x, y in places[:-1]]
        x, y = places[-1]
        flags = WaypointFlag.STOP | WaypointFlag.END
        points.append(Waypoint(x, y, 0.0, heading_rad=0.0, flags=flags))
        self.host.upload(Mission(mission, points), self.now_s, True)

    @property
    def is_done(self) -> bool:
        return self.robot.controller.done

    @property
    def state(self) -> RobotState:
        return self.robot.controller.state

    @property
    def silence(self) -> str | None:
        return self.robot.word(self.now_s).silence


def scaled_goal(name: str) -> tuple[tuple[float, float], ...]:
    """Two metres for the large ones, half a metre for the smallest."""
    far = 0.5 if name == "epuck2" else 1.0
    return (0.5 * far, 0.0), (far, 0.1 * far), (1.2 * far, 0.3 * far)


def assert_at_goal(bench: DrivenBench, name: str) -> None:
    x, y, heading = bench.drive.pose
    goal = scaled_goal(name)[-1]
    assert math.dist((x, y), goal) <= 0.010
    assert abs(math.degrees(heading)) <= 2.0


def drive_off(bench: DrivenBench, name: str, seconds: float = 2.5) -> None:
    """On its way, and really moving."""
    bench.get_ready()
    bench.send(5, *scaled_goal(name))
    bench.run(seconds)
    assert bench.state is RobotState.RUN
    assert bench.drive.moving
