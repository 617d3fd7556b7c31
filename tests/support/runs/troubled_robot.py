"""A robot in virtual time whose faults a test switches during a run. Metres, radians."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from firmware_protocol.robot.controller import WheelSpeeds
from firmware_protocol.wire.messages import ResetCause, StopReason
from navigation.link.link_snapshot import LinkSnapshot
from navigation.run.virtual_body import NOWHERE, Place, VirtualBody
from navigation.run.virtual_link import VirtualLink
from navigation.simulator.drive_model import TruePose
from navigation.simulator.virtual_loop import VirtualLoop


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
class TroubledRobot(VirtualBody):
    """One simulated robot with its troubles."""

    troubles: RobotTroubles = field(default_factory=RobotTroubles)
    frozen: bool = False
    """Its processor does nothing, and its wheels keep turning."""
    off: bool = False
    """It has no power."""

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
        return self.troubles.seen_at(self.pose())

    def double(self, _now_s: float) -> Place:
        """Place of the second marker with its id; `NOWHERE` without one."""
        return self.troubles.double_at or NOWHERE


class TroubledLink(VirtualLink):
    """The link to it, whose port may break."""

    def __init__(self, body: TroubledRobot) -> None:
        super().__init__(body.loop)
        self._troubles = body.troubles

    def snapshot(self) -> LinkSnapshot:
        """Present state."""
        snapshot = super().snapshot()
        if self._troubles.port_broken:
            return replace(snapshot, down_reason="the port virtual broke")
        return snapshot


def press_estop(body: VirtualBody) -> None:
    """Press the emergency stop on the robot itself."""
    body.loop.robot.controller.emergency_stop(StopReason.ESTOP_LOCAL)


def switch_off_and_on(body: VirtualBody) -> None:
    """Cycle the power: nothing from earlier is left in its processor."""
    body.loop.boot(ResetCause.POWER_ON)
