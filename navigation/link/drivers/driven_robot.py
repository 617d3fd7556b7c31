"""The robot's end of our wire on one side, a robot's own protocol on the other; sans-IO.

- The firmware's own code follows the wire's waypoints here from the robot's odometry, one step for
  each report of the wheels.
- A robot that does not report is out of reach: its wheels are ordered to stop, and the wire is
  silent like a pulled cable. The host waits, keeps the mission, and starts it again.
- A bumper, a cliff or a wheel in the air is an emergency stop on the robot: only a person ends it.

Metres, seconds of this process's clock.
"""

from __future__ import annotations

from collections import deque
from typing import Final

from firmware_protocol.robot.connection import Identity, RobotConnection
from firmware_protocol.robot.controller import RobotController
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.messages import RobotState, StopReason
from navigation.link.drivers.robot_driver import RobotDriver
from navigation.link.drivers.standing import Standing
from navigation.link.drivers.word_of_robot import Word, remark_of, silence_of

FRESH_S: Final = 0.25
"""Age from which wheels without a report are driven no further: at 0.3 m/s 75 mm."""
CYCLE_S: Final = 0.01
DEALT_OUT_S: Final = 1.0
"""Longest time over which late travel is dealt out."""
DEALING: Final = 1.2
"""Factor by which a wheel is believed to exceed its highest speed."""
LOOK_BACK_S: Final = 3.0
"""Time over which damaged messages are counted."""


class DrivenRobot:
    """One driver behind the wire. ``port`` and ``baud`` are only for its sentences."""

    def __init__(
        self,
        driver: RobotDriver,
        settings: DriveSettings,
        identity: Identity,
        port: str,
        baud: int,
    ) -> None:
        self.driver = driver
        self.controller = RobotController(settings)
        self._wire = RobotConnection(identity, self.controller)
        self._port, self._baud = port, baud
        self._port_fault: str | None = "the robot's port is not open yet"
        self._opened_s = 0.0
        self._stepped_s: float | None = None
        self._report_s: float | None = None
        """Arrival of the newest report known to the last step."""
        self._given = (0.0, 0.0)
        """Travel known to the controller."""
        self._messages = 0
        self._fresh_bytes = 0
        self._counts: deque[tuple[float, int, int]] = deque()
        self._standing = Standing()
        self._answers = False
        self._leaving = False

    # The robot's port.

    def port_opened(self, now_s: float) -> None:
        """Greet the robot, which stops it."""
        self._port_fault = None
        self._opened_s = now_s
        self._fresh_bytes = 0
        self.driver.heard.stranger = self.driver.heard.held = None
        self._standing.begin(now_s)
        self.driver.open(now_s)

    def port_closed(self, reason: str) -> None:
        """Note that the port is closed; ``reason`` is one sentence."""
        self._port_fault = reason

    def receive_from_robot(self, data: bytes, now_s: float) -> None:
        """Take the robot's bytes; the wheels follow at the next :meth:`tick`."""
        self._fresh_bytes += len(data)
        self.driver.receive(data, now_s)
        self._standing.look(self.driver.heard)
        if self.driver.heard.messages != self._messages:
            self._messages, self._fresh_bytes = self.driver.heard.messages, 0

    def bytes_to_robot(self, now_s: float) -> bytes:
        """Bytes due for the robot; call once the port has taken the last ones."""
        return b"" if self._port_fault is not None else self.driver.bytes_to_send(now_s)

    # The wire.

    def receive_from_host(self, data: bytes, now_s: float) -> None:
        """Take the host's bytes; lost if the robot is out of reach, as its wheels stop anyway."""
        if self._answers:
            self._wire.receive_bytes(data, now_s)

    def bytes_to_host(self, now_s: float) -> bytes:
        """Due frames."""
        frames = []
        while self._answers and (frame := self._wire.next_frame(now_s)):
            frames.append(frame)
        return b"".join(frames)

    # Both.

    def tick(self, now_s: float) -> None:
        """Step the controller for each report; call a hundred times a second or more."""
        heard, control = self.driver.heard, self.controller
        self._answers = self._is_within_reach(now_s)
        control.tick(now_s)
        if not self._answers or self._leaving:
            self._stand()
            return
        if heard.fault is not None:
            self._meet_fault()
        if self._is_time_for_a_step(now_s):
            self._step(now_s)
        wheels = control.turn_wheels(now_s)
        if wheels.powered:
            self.driver.drive(*self._bent_alike(wheels.left_m_s, wheels.right_m_s))
        else:
            self.driver.drive(0.0, 0.0)

    def leave(self) -> None:
        """Stop the wheels for good, as the process ends."""
        self._leaving = True
        self._stand()

    def word(self, now_s: float) -> Word:
        """Sentences for people about the robot."""
        heard, robot = self.driver.heard, self.driver.robot
        if self._port_fault is not None:
            return Word(silence=self._port_fault)
        if not self._answers:
            waited_s = now_s - self._opened_s
            return Word(
                silence_of(robot, self._port, self._baud, heard, self._fresh_bytes, waited_s)
            )
        fault = None if heard.fault is None else f"{robot.title}: {heard.fault}"
        remark = remark_of(robot, self._port, heard, *self._of_late(now_s))
        stands = self._standing.is_known(now_s)
        return Word(None, fault, remark, heard.identity, heard.battery, stands)

    # Inside.

    def _is_within_reach(self, now_s: float) -> bool:
        odometry_s = self.driver.heard.odometry_s
        if self._port_fault is not None or odometry_s is None:
            return False
        return now_s - odometry_s <= FRESH_S and odometry_s >= self._opened_s

    def _step(self, now_s: float) -> None:
        """Deal a report's travel out over the controller's 10 ms cycles that it took.

        No wheel turns faster than it can: a burst is dealt out over what follows.
        """
        heard, stepped_s = self.driver.heard, self._stepped_s
        since_s = CYCLE_S if stepped_s is None else min(DEALT_OUT_S, now_s - stepped_s)
        count = max(1, round(since_s / CYCLE_S))
        most_m = DEALING * self.driver.robot.wheel_m_s * since_s / count
        for left in range(count, 0, -1):
            moves = (heard.left_m - self._given[0], heard.right_m - self._given[1])
            parts = max(left, *(abs(move) / most_m for move in moves))
            self._given = (self._given[0] + moves[0] / parts, self._given[1] + moves[1] / parts)
            self.controller.follow(now_s - (left - 1) * since_s / count, *self._given)
        self._stepped_s, self._report_s = now_s, heard.odometry_s

    def _is_time_for_a_step(self, now_s: float) -> bool:
        """True at each report, and while travel is still being dealt out."""
        heard = self.driver.heard
        if self._stepped_s is None:
            return True
        if now_s <= self._stepped_s:
            return False
        if heard.odometry_s != self._report_s:
            return True
        return self._given != (heard.left_m, heard.right_m) and now_s - self._stepped_s >= CYCLE_S

    def _stand(self) -> None:
        """Stop without a ramp, as the wheels' motion is unknown."""
        self.controller.stand()
        self.driver.drive(0.0, 0.0)

    def _meet_fault(self) -> None:
        """Stop in an emergency until a person resets it; then the fault must be gone."""
        if self.controller.state is not RobotState.ESTOP:
            if self._stopped_for_fault:
                self._stopped_for_fault = False
                self.driver.clear_fault()  # a person has reset the stop
                return
            self.controller.emergency_stop(StopReason.ESTOP_LOCAL)
            self._stopped_for_fault = True

    _stopped_for_fault = False

    def _bent_alike(self, left_m_s: float, right_m_s: float) -> tuple[float, float]:
        """Slow both wheels if one is asked to turn too fast: the bend stays."""
        share = max(abs(left_m_s), abs(right_m_s)) / self.driver.robot.wheel_m_s
        return (left_m_s, right_m_s) if share <= 1.0 else (left_m_s / share, right_m_s / share)

    def _of_late(self, now_s: float) -> tuple[int, int]:
        heard, counts = self.driver.heard, self._counts
        if not counts or now_s - counts[-1][0] >= 0.1:
            counts.append((now_s, heard.damaged, heard.messages))
        while now_s - counts[0][0] > LOOK_BACK_S:
            counts.popleft()
        return heard.damaged - counts[0][1], heard.messages - counts[0][2]
