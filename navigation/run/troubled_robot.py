"""A simulated robot in virtual time and its faults. Metres, radians, virtual seconds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final, TypeAlias

from firmware_protocol.robot.controller import WheelSpeeds
from firmware_protocol.wire.messages import ResetCause
from navigation.config import Config
from navigation.simulator.drive_model import TruePose
from navigation.simulator.line_faults import FaultSpec
from navigation.simulator.settings import (
    drive_model_of,
    drive_settings_of,
    faults_of,
    true_start_of,
)
from navigation.simulator.virtual_loop import VirtualLoop
from navigation.simulator.virtual_robot import VirtualRobot

Place: TypeAlias = tuple[float, float, float]
NOWHERE: Final[Place] = (-9.0, -9.0, 0.0)
"""Far outside the picture."""


@dataclass(slots=True)
class RobotTroubles:
    """Faults that a test may switch during a run; none at first."""

    marker_hidden: bool = False
    marker_at: Place | None = None
    """Pictures show the robot here."""
    marker_shift_m: tuple[float, float] = (0.0, 0.0)
    """Pictures show it this far from its place."""
    marker_turned: bool = False
    """Its marker is mounted the wrong way round."""
    double_at: Place | None = None
    """Place of a second marker with its id."""
    port_broken: bool = False
    """Nothing passes, and the port cannot be opened."""
    cable_out: bool = False
    """Nothing passes in either direction, without an error."""
    wire_to_robot_cut: bool = False
    """Its reports still come."""
    motors_dead: bool = False
    """The wheels do not turn."""
    carried_to: Place | None = None
    """A person puts the robot there, once."""
    stuck: bool = False
    """The wheels turn and the robot stays where it is."""
    stuck_at: TruePose | None = None
    """Its pose while stuck."""

    def meet(self, loop: VirtualLoop) -> None:
        """Apply the present faults."""
        loop.knobs.cable = not (self.cable_out or self.port_broken)
        loop.knobs.to_robot = not self.wire_to_robot_cut
        loop.drive.has_power = not self.motors_dead
        if self.carried_to is not None:
            loop.drive.put_down(TruePose(*self.carried_to))
            self.carried_to = None
        if self.stuck:
            self.stuck_at = self.stuck_at or loop.drive.pose
            loop.drive.pose = self.stuck_at
        else:
            self.stuck_at = None

    def seen_at(self, true: TruePose) -> Place:
        """Place at which pictures show a robot at ``true``."""
        if self.marker_hidden:
            return NOWHERE
        if self.marker_at is not None:
            return self.marker_at
        dx, dy = self.marker_shift_m
        turn = math.pi if self.marker_turned else 0.0
        return true.x_m + dx, true.y_m + dy, true.heading_rad + turn


@dataclass(slots=True)
class ProcessorFaults:
    """Configured faults of a robot's processor: it hangs, and it restarts."""

    faults: FaultSpec

    def meet(self, loop: VirtualLoop, since_s: float) -> None:
        """Apply the faults due ``since_s`` after the beginning."""
        loop.knobs.frozen = 0.0 <= since_s - self.faults.freeze_at_s < self.faults.freeze_s
        if since_s >= self.faults.reset_at_s:
            self.faults = replace(self.faults, reset_at_s=math.inf)
            loop.boot(ResetCause.EXTERNAL)


@dataclass(slots=True)
class TroubledRobot:
    """One simulated robot with its line and its faults."""

    config: Config
    loop: VirtualLoop
    robot: VirtualRobot
    processor: ProcessorFaults
    troubles: RobotTroubles = field(default_factory=RobotTroubles)
    frozen: bool = False
    """Its processor does nothing, and its wheels keep turning."""
    off: bool = False
    """It has no power."""

    @classmethod
    def of(cls, config: Config) -> TroubledRobot:
        """Make the configured robot and its line; camera and lease are the program's."""
        assert config.simulation is not None
        loop = VirtualLoop(
            seed=config.simulation.seed,
            faults=faults_of(config),
            model=drive_model_of(config),
            settings=drive_settings_of(config),
            start=true_start_of(config),
            baud=config.serial.baud,
        )
        return cls(config, loop, VirtualRobot(loop), ProcessorFaults(faults_of(config)))

    def tick(self, since_s: float) -> None:
        """Simulate one millisecond, ``since_s`` after the beginning."""
        loop = self.loop
        self.processor.meet(loop, since_s)
        loop.knobs.frozen |= self.frozen or self.off
        if self.off:
            loop.wheels = WheelSpeeds(0.0, 0.0, powered=False)
        self.troubles.meet(loop)
        loop.tick()

    def seen(self, _now_s: float) -> Place:
        """Place at which pictures of the present moment show it."""
        return self.troubles.seen_at(self.robot.pose())

    def double(self, _now_s: float) -> Place:
        """Place of the second marker with its id; `NOWHERE` without one."""
        return self.troubles.double_at or NOWHERE
