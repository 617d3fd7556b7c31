"""A simulated robot in virtual time, and what may go wrong on order: camera, cable, port, people.

Metres, radians.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field, replace

from firmware_protocol.wire.messages import ResetCause
from navigation.config import Config
from navigation.run.troubled_camera import CameraTroubles
from navigation.simulator.drive_model import TruePose
from navigation.simulator.line_faults import FaultSpec
from navigation.simulator.settings import (
    drive_model_of,
    drive_settings_of,
    faults_of,
    true_start_of,
)
from navigation.simulator.virtual_loop import VirtualLoop


@dataclass(slots=True)
class Troubles(CameraTroubles):
    """What a test may switch while a run goes on; everything is well in the beginning."""

    port_broken: bool = False
    """The port is gone: nothing passes, and it cannot be opened."""
    cable_out: bool = False
    """Nothing passes in either direction, without an error."""
    wire_to_robot_cut: bool = False
    """A cut wire to the robot: nothing sent reaches it, and its reports still come."""
    motors_dead: bool = False
    """The wheels do not turn, whatever is ordered."""
    carried_to: tuple[float, float, float] | None = None
    """Somebody takes the robot and puts it there, once."""
    stuck: bool = False
    """The wheels turn and the robot stays where it is."""
    cameras: defaultdict[str, CameraTroubles] = field(
        default_factory=lambda: defaultdict(CameraTroubles)
    )
    """Of several cameras, by name; what the picture shows of the robot is the same in all."""
    stuck_at: TruePose | None = None
    """Where it stays, once it does."""

    def meet(self, loop: VirtualLoop) -> None:
        """Do to a robot and its line what is wrong at this moment."""
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


@dataclass(slots=True)
class ProcessorFaults:
    """The configured faults of a robot's processor, at their times: it hangs, and it restarts."""

    faults: FaultSpec

    def meet(self, loop: VirtualLoop, since_s: float) -> None:
        """Do to the processor what is due ``since_s`` after the beginning."""
        loop.knobs.frozen = 0.0 <= since_s - self.faults.freeze_at_s < self.faults.freeze_s
        if since_s >= self.faults.reset_at_s:
            self.faults = replace(self.faults, reset_at_s=math.inf)
            loop.boot(ResetCause.EXTERNAL)


def virtual_loop_of(config: Config) -> VirtualLoop:
    """The configured robot and its line; camera and lease are the program's."""
    assert config.simulation is not None
    loop = VirtualLoop(
        seed=config.simulation.seed,
        faults=faults_of(config),
        model=drive_model_of(config),
        settings=drive_settings_of(config),
        start=true_start_of(config),
        baud=config.serial.baud,
    )
    loop.knobs.camera = loop.knobs.lease = False
    return loop
