"""Host, line, the AVR binary on its emulated processor, motors and encoders, in lockstep."""

from __future__ import annotations

import random
from collections.abc import Callable

import numpy as np

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import Event
from firmware_protocol.wire.framing import FrameParser, Sender
from firmware_protocol.wire.messages import MessageType, RobotState
from navigation.simulator.line_faults import FaultSpec, FaultyLine
from tests.support.robots.avr_robot import AvrRobot
from tests.support.robots.emulated_processor import EmulatedProcessor, Motors

TICK_S = 0.001
LAG_S = 0.05
"""The motors follow their outputs with this time constant."""
LEASE_EVERY = 50
"""Ticks from one lease to the next."""
WIRE_BYTE_S = 10.0 / 115_200


class AvrBench:
    """The robot begins with a reset; :meth:`tick` is one millisecond."""

    def __init__(self, avr: AvrRobot | EmulatedProcessor, seed: int = 1, faults: str = "") -> None:
        self.avr, self.now_s = avr, 0.0
        self.host = HostConnection(random.Random(seed))
        self.host.open(0.0)
        rng, spec = np.random.default_rng(seed), FaultSpec.parse(faults)
        self.lines = (FaultyLine(spec, rng), FaultyLine(spec, rng))
        self.waiting = b""
        self.speed = [0.0, 0.0]
        self.lease = True
        self.lease_phase = 0
        """Ticks by which the leases come earlier."""
        self.leased_s = 0.0
        """When the last lease had come through the line."""
        self.silence_s = 0.0
        """The longest time in which the processor said nothing, since a test set it to 0."""
        self._heard_s = 0.0
        self.events: list[Event] = []
        self.motors = Motors(0.0, 0.0, False, 0.0, 0.0)
        self._leases = FrameParser(Sender.HOST)
        self.tick(reset=True)

    def tick(self, reset: bool = False) -> None:
        travel = (self.speed[0] * TICK_S, self.speed[1] * TICK_S)
        if any(frame.kind == MessageType.LEASE for frame in self._leases.feed(self.waiting)):
            self.leased_s = self.now_s + len(self.waiting) * WIRE_BYTE_S
        self.motors, data = self.avr.run(TICK_S, self.waiting, travel, reset)
        for side in (0, 1):
            self.speed[side] += TICK_S / LAG_S * (self.motors[side] - self.speed[side])
        self.now_s += TICK_S
        self.silence_s = max(self.silence_s, self.now_s - self._heard_s)
        if data:
            self._heard_s = self.now_s
        tick = round(self.now_s / TICK_S) + self.lease_phase
        if tick % LEASE_EVERY == 0 and self.lease:
            self.host.lease(self.now_s, 0.5, True, odometry=True)
        self.host.receive_bytes(self.lines[1].carry(data, self.now_s), self.now_s)
        self.host.tick(self.now_s)
        self.waiting = self.lines[0].carry(self.host.bytes_to_send(self.now_s), self.now_s)
        while (event := self.host.next_event()) is not None:
            self.events.append(event)

    def state(self) -> RobotState | None:
        return None if self.host.status is None else self.host.status.state

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK_S)):
            self.tick()

    def until(self, holds: Callable[[], bool], seconds: float) -> None:
        """Run until that holds; TimeoutError where it does not in time."""
        end_s = self.now_s + seconds
        while not holds():
            if self.now_s > end_s:
                raise TimeoutError(f"not after {seconds} s: {self.host.status}")
            self.tick()
