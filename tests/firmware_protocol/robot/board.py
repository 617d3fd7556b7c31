"""The robot's end on a table: a test sends frames by hand and reads the answers."""

from firmware_protocol.robot.connection import (
    Identity,
    RobotConnection,
)
from firmware_protocol.robot.controller import RobotController
from firmware_protocol.wire.framing import FrameParser, Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import (
    RELIABLE,
    SCHEMA_HASH,
    Clear,
    Confirm,
    Hello,
    Lease,
    LeaseFlag,
    Message,
    RobotState,
    Start,
    Status,
    Waypoint,
    Waypoints,
    read_message,
)
from firmware_protocol.wire.mission import Mission
from tests.support.robots.inside import nonce_of


class Board:
    """A robot on the table: its wheels do what they are told, exactly."""

    def __init__(self) -> None:
        self.control = RobotController()
        self.robot = RobotConnection(Identity(77), self.control)
        self.parser = FrameParser(Sender.ROBOT)
        self.now_s = 10.0
        self.wheels = [0.0, 0.0]
        self.session = 0
        self.sequence = 0
        self.answers: list[Message] = []
        self.last = self.control.step(self.now_s, 0.0, 0.0)

    def send(
        self, message: Message, sequence: int | None = None, session: int | None = None
    ) -> None:
        reliable = message.TYPE in RELIABLE
        frame = WireFrame(
            message.TYPE,
            self.session if session is None else session,
            message.pack(),
            self.sequence if sequence is None and reliable else sequence or 0,
            reliable=reliable,
        )
        if reliable and sequence is None:
            self.sequence = (self.sequence + 1) % 256
        self.robot.receive_bytes(encode_frame(frame, Sender.HOST), self.now_s)

    @property
    def clock_us(self) -> int:
        return round(self.now_s * 1e6)

    def hello(self, session: int) -> None:
        """Ask for a session, and give the challenge back."""
        self.session, self.sequence = session, 0
        self.send(Hello(SCHEMA_HASH))
        if self.robot.session != session:
            self.send(Confirm(nonce_of(self.robot)))

    def lease(self, flags: LeaseFlag = LeaseFlag.PERMIT | LeaseFlag.ODOMETRY) -> None:
        self.send(Lease(0.5, flags, 0.0, self.clock_us))

    def pass_time(self, seconds: float) -> None:
        for _ in range(max(1, round(seconds / 0.01))):
            self.now_s += 0.01
            for side in (0, 1):
                self.wheels[side] += 0.01 * self.last[side]
            self.last = self.control.step(self.now_s, *self.wheels)
            while frame := self.robot.next_frame(self.now_s):
                self.answers += [read_message(f) for f in self.parser.feed(frame)]

    def answer(self, kind: type[Message]) -> Message:
        self.answers.clear()
        self.pass_time(0.06)
        return next(m for m in reversed(self.answers) if isinstance(m, kind))

    def status(self) -> Status:
        status = self.answer(Status)
        assert isinstance(status, Status)
        return status

    def run(self, mission: Mission) -> None:
        self.hello(5)
        self.lease()
        self.send(Clear(1, mission.id))
        for first in range(0, min(30, len(mission)), 6):
            self.send(Waypoints(mission.id, first, mission.records[first : first + 6]))
        self.send(Start(2, mission.id, 0))
        assert self.control.state is RobotState.RUN


def far(count: int = 3) -> Mission:
    return Mission(9, [Waypoint(1.0 + 0.1 * i, 0.0, 0.3) for i in range(count)])
