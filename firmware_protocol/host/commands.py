"""The host's wishes as commands: one at a time, until STATUS reports its outcome.

START retries for a moment while a lease or a pose is on its way. After a lost link only a new wish
moves the robot.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, TypeAlias

from firmware_protocol.host.events import CommandEnded
from firmware_protocol.host.upload import Upload
from firmware_protocol.wire.messages import (
    Clear,
    CommandResult,
    MessageType,
    Pause,
    ResetEstop,
    RobotState,
    Start,
    Status,
)

RETRY_S: Final = 0.5
"""Time after which an acknowledged command that STATUS does not answer is sent again."""
START_PATIENCE_S: Final = 1.0
START_RETRY_S: Final = 0.05
_MAY_COME: Final = (CommandResult.NO_LEASE, CommandResult.NO_POSE, CommandResult.WRONG_INDEX)
"""Refusals of START that may pass: no lease, no pose, or a robot not yet at rest."""

Command: TypeAlias = Pause | Clear | Start | ResetEstop


@dataclass(frozen=True, slots=True)
class _Outstanding:
    number: int
    kind: MessageType
    sent_s: float


class Commands:
    """The user's wishes, and the command awaiting its answer."""

    def __init__(self) -> None:
        self.reset_wanted = False
        """True while the robot still has to leave its emergency stop."""
        self._pause = False
        self._clear = False
        self._start_s: float | None = None
        """Time of the wish to start, if any."""
        self._start_again_s = -math.inf
        self._number = 0
        self._waiting: _Outstanding | None = None

    def want_start(self, now_s: float) -> None:
        """Wish to drive the mission."""
        self._pause = False
        self._start_s, self._start_again_s = now_s, -math.inf

    def want_no_start(self) -> None:
        """Withdraw the wish to drive if it has not begun."""
        self._start_s = None

    def want_pause(self) -> None:
        """Wish to stop under control, mission kept."""
        self._start_s, self._pause = None, True

    def want_clear(self) -> None:
        """Wish to stop under control, mission forgotten."""
        self._start_s, self._pause, self._clear = None, False, True

    def want_mission(self) -> None:
        """Drop all wishes about the last mission."""
        self._start_s, self._pause, self._clear = None, False, False

    def next(
        self, status: Status, upload: Upload | None, all_acknowledged: bool, now_s: float
    ) -> Command | None:
        """Next command, the most urgent wish first; it counts as sent."""
        waiting = self._waiting
        overdue = waiting is not None and all_acknowledged and now_s - waiting.sent_s > RETRY_S
        if waiting is not None and not overdue:
            return None
        command = self._choose(self._number % 0xFFFF + 1, status, upload, now_s)
        if command is not None:
            self._number = command.command
            self._waiting = _Outstanding(command.command, command.TYPE, now_s)
        return command

    def _choose(
        self, number: int, status: Status, upload: Upload | None, now_s: float
    ) -> Command | None:
        if self.reset_wanted:
            return ResetEstop(number)
        if self._pause:
            return Pause(number)
        self._clear = self._clear and status.mission != 0
        if self._clear:
            return Clear(number, 0)
        if upload is None or status.state is RobotState.ESTOP:
            return None
        if not upload.on_robot:
            return Clear(number, upload.mission.id)
        wanted = self._start_s is not None and now_s >= self._start_again_s
        if wanted and (upload.blocked or upload.complete):
            return Start(number, upload.mission.id, upload.executed)
        return None

    def due_times_s(self) -> Iterator[float]:
        """Times at which the wait for an answer ends, and the pause before another START."""
        if self._waiting is not None:
            yield self._waiting.sent_s + RETRY_S
        if self._start_s is not None:
            yield self._start_again_s

    def settle(self, status: Status, now_s: float) -> CommandEnded | None:
        """Look for the answer in a report; return the command's end if found."""
        waiting = self._waiting
        if waiting is None or status.command != waiting.number:
            return None
        self._waiting = None
        match waiting.kind:
            case MessageType.START:
                asked_s = self._start_s
                recent = asked_s is not None and now_s - asked_s < START_PATIENCE_S
                if recent and status.result in _MAY_COME:
                    self._start_again_s = now_s + START_RETRY_S
                    return None
                self._start_s = None
            case MessageType.PAUSE:
                self._pause = False
            case MessageType.RESET_ESTOP:
                self.reset_wanted = False
            case MessageType.CLEAR if status.mission == 0:
                self._clear = False
        return CommandEnded(waiting.kind, status.result)

    def give_up(self) -> CommandEnded | None:
        """End the session: command in flight and wish to drive are void."""
        waiting, self._waiting = self._waiting, None
        start_s, self._start_s = self._start_s, None
        self._number = 0
        if waiting is None and start_s is None:
            return None
        kind = MessageType.START if waiting is None else waiting.kind
        return CommandEnded(kind, CommandResult.NONE)
