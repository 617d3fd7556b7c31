"""A simulated robot in virtual time, with its line. Metres, radians, virtual seconds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final, Self, TypeAlias

import numpy as np

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
from planner.scene import FloatArray

Place: TypeAlias = tuple[float, float, float]
NOWHERE: Final[Place] = (-9.0, -9.0, 0.0)
"""Far outside the picture."""
KEPT_EVERY: Final = 2
"""Every second of the loop's 10 ms is kept in the robot's track."""


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
class VirtualBody:
    """One simulated robot with its line and its configured faults."""

    config: Config
    loop: VirtualLoop
    processor: ProcessorFaults
    _rows: list[tuple[float, float, float, float]] = field(default_factory=list, init=False)
    _noted: int = field(default=0, init=False)

    @classmethod
    def of(cls, config: Config) -> Self:
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
        return cls(config, loop, ProcessorFaults(faults_of(config)))

    def tick(self, since_s: float) -> None:
        """Simulate one millisecond, ``since_s`` after the beginning."""
        self.processor.meet(self.loop, since_s)
        self.loop.tick()

    def pose(self) -> TruePose:
        """Present pose."""
        return self.loop.drive.pose

    def track(self) -> FloatArray:
        """Track so far, every 20 ms."""
        return np.array(self._rows).reshape(-1, 4)

    def keep_track(self) -> None:
        """Take over the loop's notes since the last call."""
        noted = self.loop.track
        self._rows += noted[-self._noted % KEPT_EVERY :: KEPT_EVERY]
        self._noted += len(noted)
        noted.clear()

    def seen(self, _now_s: float) -> Place:
        """Place at which pictures of the present moment show it."""
        return self.pose()

    def double(self, _now_s: float) -> Place:
        """Place of a second marker with its id: out of sight, yet it draws its share of noise."""
        return NOWHERE
