"""A virtual loop with a mission, and what the robot really executes: the judge of every scenario.

Three kinds of robot stand behind the line: the one in Python, whose every executed record is seen;
C in this process, whose chain's CRC tells; and the AVR binary on an emulated processor, of which
only reports and motors are known, each report being judged.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass, field

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import MissionDone
from firmware_protocol.robot.clearway.wire import WAYPOINT_BYTES
from firmware_protocol.robot.connection import Identity, RobotConnection
from firmware_protocol.robot.controller import RobotController
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.messages import ResetCause, RobotState, StopReason, Waypoint
from firmware_protocol.wire.mission import Mission
from navigation.simulator.line_faults import FaultSpec
from navigation.simulator.virtual_loop import PacedLine, python_robot
from tests.support.robots.avr_firmware import TOLD_S, AvrFirmware
from tests.support.runs.scenario_loop import ScenarioLoop

DEAD_MAN_S = 0.5
RobotMaker = Callable[[Identity, DriveSettings], RobotConnection]
robot_maker: ContextVar[RobotMaker] = ContextVar("robot_maker", default=python_robot)
"""Which robot the scenarios run on; the C firmware takes the Python one's place here."""
STOP_S = 1.1
"""From 0.4 m/s with 0.5 m/s2 and slow motors."""


@dataclass
class Witness:
    """A loop with a mission, and what the robot really executed."""

    seed: int
    faults: FaultSpec = field(default_factory=FaultSpec)
    count: int = 40
    spacing_m: float = 0.02
    loop: ScenarioLoop = field(init=False)
    mission: Mission = field(init=False)
    executed: list[bytes] = field(default_factory=list)
    notes: bool = field(default=True, init=False)
    options: dict[str, float] = field(default_factory=dict)
    given: dict[int, Mission] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        self.loop = ScenarioLoop(
            seed=self.seed,
            faults=self.faults,
            make_robot=robot_maker.get(),
            **self.options,  # type: ignore[arg-type]
        )
        if self.told_s:  # the emulated UART takes its time itself, in both directions
            self.loop.to_robot, self.loop.to_host = PacedLine(math.inf), PacedLine(math.inf)
        self.mission = self.new_mission(1000 + self.seed)
        self.watch()

    def watch(self) -> None:
        """Note what the present robot executes; C tells by its chain's CRC only."""
        present: object = self.loop.robot
        if isinstance(present, AvrFirmware):
            present.encoders_m = lambda: self.loop.drive.encoders_m
        control = self.loop.robot.controller
        self.notes = isinstance(control, RobotController)
        if not self.notes:
            return
        robot, original = control.robot, control.robot._execute

        def noting(count: int) -> None:
            for index in range(count):
                at = robot.queue.at(index)
                self.executed.append(bytes(robot.queue.data[at : at + WAYPOINT_BYTES]))
            original(count)

        robot._execute = noting  # type: ignore[method-assign]

    def boot(self, cause: ResetCause = ResetCause.EXTERNAL) -> None:
        """The robot's processor starts anew."""
        self.loop.boot(cause)
        self.executed.clear()
        self.watch()

    def new_mission(self, number: int) -> Mission:
        """A gentle bend from where the robot is."""
        x, y, heading = self.loop.drive.pose
        rng = random.Random(number)
        bend = rng.uniform(-1.0, 1.0)
        waypoints = []
        for _ in range(self.count):
            heading += bend * self.spacing_m
            x += self.spacing_m * math.cos(heading)
            y += self.spacing_m * math.sin(heading)
            waypoints.append(Waypoint(x, y, 0.4))
        mission = self.given[number] = Mission(number, waypoints)
        return mission

    @property
    def told_s(self) -> float:
        """How late the robot's state is known."""
        return TOLD_S if isinstance(self.loop.robot, AvrFirmware) else 0.0

    @property
    def robot_clock_s(self) -> float:
        """What the robot's own clock says, without its wrap."""
        robot: object = self.loop.robot
        return robot.clock_s if isinstance(robot, AvrFirmware) else self.loop.robot_s

    def inject(self, data: bytes) -> None:
        """Bytes into the robot's receiver at once; a UART takes them no faster than the line."""
        loop = self.loop
        loop.robot.receive_bytes(data, loop.robot_s)
        if self.told_s:
            loop.run(15.0 * len(data) / loop.baud)  # half as much again, for the host's own

    def reaches(self, state: RobotState, within_s: float = 0.0) -> bool:
        """Whether the robot is, or comes, into that state in time."""
        if self.state is state:
            return True
        return self.loop.run(within_s + self.told_s, lambda: self.state is state)

    @property
    def state(self) -> RobotState:
        return self.loop.robot.controller.state

    def connect(self, patience_s: float = 10.0) -> None:
        up = self.loop.run(patience_s, lambda: self.loop.host.state.is_up)
        assert up, self.loop.host.why_down(self.loop.now_s)

    def give(self) -> None:
        self.loop.host.upload(self.mission, self.loop.now_s)

    def begin(self) -> None:
        """Connect, let the camera see the robot, and start the mission."""
        self.connect()
        self.loop.run(0.3)
        self.give()

    def begin_and_drive(self, seconds: float = 0.8) -> None:
        self.begin()
        running = self.loop.run(10.0, lambda: self.state is RobotState.RUN)
        assert running, self.loop.robot.controller.reason
        self.loop.run(seconds)

    def finish(self, patience_s: float = 30.0) -> str:
        """Drive on, starting again whenever the robot was stopped, until the mission is done."""
        end_s = self.loop.now_s + patience_s
        restarts = 0
        while self.loop.now_s < end_s:
            if self.loop.run(0.5, self.is_done):
                self.judge_chain(whole=True)
                return "executed" if not restarts else "stopped, then executed"
            host = self.loop.host
            standing = self.state in (RobotState.HOLD, RobotState.IDLE)
            if host.state.is_up and standing and host.upload_state is not None:
                host.start(self.loop.now_s)
                restarts += 1
        raise AssertionError(f"not done after {patience_s} s: {self.describe()}")

    def is_done(self) -> bool:
        done = MissionDone(self.mission.id)
        return any(event == done for event in self.loop.events)

    def judge_chain(self, whole: bool) -> None:
        """What was executed is what was sent, in order, nothing doubled; whole or a beginning."""
        records = list(self.mission.records)
        control = self.loop.robot.controller
        self.judge_reports()
        if not self.notes and control.mission == self.mission.id:
            assert control.exec_crc == self.mission.prefix_crc(control.exec_next)
            assert not whole or control.exec_next == len(records)
            return
        expected = records if whole else records[: len(self.executed)]
        assert self.executed == expected, f"{len(self.executed)} executed of {len(records)}"
        if control.mission == self.mission.id:
            assert control.exec_crc == self.mission.prefix_crc(control.exec_next)
            assert control.exec_next == len(self.executed)

    def judge_reports(self) -> None:
        """In every report of the AVR the chain is the mission's, and never goes back."""
        robot: object = self.loop.robot
        if not isinstance(robot, AvrFirmware):
            return
        before: dict[int, int] = {}
        for report in robot.reports:
            mission = self.given.get(report.mission)
            if mission is not None:
                assert report.exec_crc == mission.prefix_crc(report.exec_next), report
                assert report.prefix_crc == mission.prefix_crc(report.accept_next), report
                assert report.exec_next >= before.get(mission.id, 0), report
                before[mission.id] = report.exec_next

    def judge_standing(self, within_s: float, reason: StopReason | None = None) -> None:
        """The robot stands within that time and stays so."""
        self.loop.run(within_s)
        assert self.state is not RobotState.RUN, self.describe()
        assert not self.loop.drive.moving, f"still moving after {within_s} s"
        if reason is not None:
            assert self.loop.robot.controller.reason is reason, self.describe()
        x, y, _ = self.loop.drive.pose
        self.loop.run(0.5)
        x2, y2, _ = self.loop.drive.pose
        assert math.hypot(x2 - x, y2 - y) < 1e-3

    def describe(self) -> str:
        control = self.loop.robot.controller
        return (
            f"robot {control.state.name} ({control.reason.name}), "
            f"{control.exec_next}/{control.accept_next}/{len(self.mission)}, "
            f"host {self.loop.host.state.name}: {self.loop.host.why_down(self.loop.now_s)}"
        )


def join_line(loop: ScenarioLoop, seed: int) -> tuple[HostConnection, HostConnection]:
    """Let another host open the loop's line, beside the one that is there: (first, second).

    Both hear the robot; what the first says goes out too.
    """
    first = loop.host
    loop.host = second = HostConnection(random.Random(seed), loop.baud)
    second.open(loop.now_s)
    carry = loop._faulty[1].carry

    def both(data: bytes, now_s: float) -> bytes:
        arrived = carry(data, now_s)
        first.receive_bytes(arrived, now_s)
        first.tick(now_s)
        said = first.bytes_to_send(now_s)
        if said:
            loop.to_robot.put(said, now_s)
        return arrived

    loop._faulty[1].carry = both  # type: ignore[method-assign]
    return first, second
