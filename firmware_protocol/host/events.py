"""Events of the host's end of the link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.host.state import LinkState
from firmware_protocol.wire.messages import CommandResult, MessageType, ResetCause, Status


@dataclass(frozen=True, slots=True)
class LinkChanged:
    """The link's state changed, with the reason."""

    old: LinkState
    new: LinkState
    reason: str


@dataclass(frozen=True, slots=True)
class StatusReceived:
    """The robot reported."""

    status: Status
    at_s: float


@dataclass(frozen=True, slots=True)
class CommandEnded:
    """A command was carried out (DONE), refused, or given up (NONE: the link broke)."""

    kind: MessageType
    result: CommandResult


@dataclass(frozen=True, slots=True)
class MissionAccepted:
    """The robot has all waypoints of the mission."""

    mission: int


@dataclass(frozen=True, slots=True)
class MissionDone:
    """All waypoints are executed; the chain of executed waypoints agrees."""

    mission: int


@dataclass(frozen=True, slots=True)
class MissionVoid:
    """The mission cannot continue; plan again and give a new one."""

    mission: int
    reason: str


@dataclass(frozen=True, slots=True)
class RobotRebooted:
    """The robot's processor has restarted; its queue is gone."""

    boot_id: int
    cause: ResetCause


@dataclass(frozen=True, slots=True)
class StrayHello:
    """Another host, or an old frame, has asked the robot for a session; it stays ours."""

    session: int


@dataclass(frozen=True, slots=True)
class EstopConfirmed:
    """The robot has reported ESTOP."""


Event: TypeAlias = (
    LinkChanged
    | StatusReceived
    | CommandEnded
    | MissionAccepted
    | MissionDone
    | MissionVoid
    | RobotRebooted
    | EstopConfirmed
    | StrayHello
)
