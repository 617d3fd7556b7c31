"""Host and robot on a table, frame by frame, with a line between them that a test may change."""

import random

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import (
    Event,
)
from firmware_protocol.robot.connection import Identity, RobotConnection
from firmware_protocol.robot.controller import RobotController
from firmware_protocol.wire.messages import (
    SCHEMA_HASH,
    Waypoint,
)
from firmware_protocol.wire.mission import Mission

TICK_S = 0.005


class Table:
    """Host and robot, frame by frame; ``line`` may change what passes."""

    def __init__(self, seed: int = 1, baud: int | None = None) -> None:
        self.host = HostConnection(random.Random(seed), baud)
        self.boot(1)
        self.now_s = 50.0
        self.wheels = [0.0, 0.0]
        self.sent: list[bytes] = []
        self.events: list[Event] = []
        self.cable = True
        self.lease = True
        self.host.open(self.now_s)

    def boot(self, boot_id: int, schema: int = SCHEMA_HASH) -> None:
        self.control = RobotController()
        self.robot = RobotConnection(Identity(boot_id, schema=schema), self.control)

    def to_robot(self, data: bytes) -> list[bytes]:
        return [data]

    def to_host(self, data: bytes) -> list[bytes]:
        return [data]

    def tick(self) -> None:
        self.now_s += TICK_S
        steps = round(self.now_s / TICK_S)
        if self.lease and steps % 20 == 0:
            self.host.lease(self.now_s, 0.5, True, odometry=True)
        self.host.tick(self.now_s)
        while data := self.host.bytes_to_send(self.now_s):
            self.sent.append(data)
            for part in self.to_robot(data) if self.cable else ():
                self.robot.receive_bytes(part, self.now_s)
        if steps % 2 == 0:
            for side in (0, 1):
                self.wheels[side] += 2 * TICK_S * self.control.wheels[side]
            self.control.step(self.now_s, *self.wheels)
        while data := self.robot.next_frame(self.now_s):
            for part in self.to_host(data) if self.cable else ():
                self.host.receive_bytes(part, self.now_s)
        while (event := self.host.next_event()) is not None:
            self.events.append(event)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK_S)):
            self.tick()


def line(number: int = 9, count: int = 40) -> Mission:
    return Mission(number, [Waypoint(0.02 * (i + 1), 0.0, 0.4) for i in range(count)])
