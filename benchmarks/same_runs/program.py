"""The program as these runs see it: the one file that knows how a run is made, of one or several.

It uses the public functions of runs in virtual time, the world's links, and the troubles that the
simulated world offers. When the program changes, this file follows it and the hashes stay.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

from benchmarks.same_runs.trace import Trace
from firmware_protocol.robot.clearway.wire import WAYPOINT_BYTES
from firmware_protocol.robot.connection import Identity, RobotConnection
from firmware_protocol.robot.controller import RobotController
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.messages import Lease, PoseFix, StopReason, Waypoints
from navigation.config import Config
from navigation.config.known_robots import CLEARWAY
from navigation.config.several.each_camera import each_camera
from navigation.config.several.each_robot import robots_of
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RobotSnapshot, RunState
from navigation.mission.mission import Station
from navigation.run.virtual_link import VirtualLink
from navigation.run.virtual_run import run_virtually
from navigation.simulator.virtual_loop import VirtualLoop
from tests.support.runs.troubled_robot import TroubledRobot
from tests.support.runs.troubled_world import CameraTroubles, TroubledWorld

# fmt: off
CALLS: Final = frozenset((
    "open", "close", "restart", "upload", "release", "pause", "clear", "lease", "pose_fix",
    "estop", "reset_estop",
))
"""What a link is ordered to do; asking it for its state changes nothing."""
# fmt: on


@dataclass(frozen=True, slots=True)
class Stage:
    """A running program and its simulated world; robots are numbered as in the configuration."""

    bodies: Sequence[TroubledRobot]
    cameras: Sequence[CameraTroubles]
    clock: Callable[[], float]
    _people: Any
    _names: Sequence[str]
    """Empty where there is one robot: it has no name."""

    def order(self, name: str, robot: int | None, *given: object) -> None:
        """``stop``, ``pause``, ``resume``, ``replan``: to one robot, or to all (None)."""
        of = (self._names[robot],) if self._names and robot is not None else ()
        getattr(self._people, name)(*given, *of)

    def give(self, robot: int, stations: tuple[Station, ...]) -> None:
        """Give a robot a new mission."""
        self.order("give", robot, stations)


Look = Callable[[Stage, Sequence[RobotSnapshot]], bool]
"""Called after each cycle with the state of each robot; True ends the run."""


@dataclass(frozen=True, slots=True)
class End:
    """The end of a run."""

    state: str
    duration_s: float


def runs_virtually(config: Config) -> bool:
    """True if the configuration is one of a simulation that needs no real time."""
    robots = robots_of(config)
    return config.simulation is not None and all(
        one.robot.driver == CLEARWAY for one in robots.values()
    )


def count_robots(config: Config) -> int:
    """The number of robots that the program drives."""
    return len(config.robots) or 1


def run(config: Config, trace: Trace, look: Look, *, linger_s: float, pictures: bool) -> End:
    """Drive a configuration to its end and note everything in the trace."""
    stages: list[Stage] = []

    def seen(daemon: Daemon, now: RunState) -> bool:
        if not stages:
            stages.append(_stage_of(daemon))
        return look(stages[0], list(now.robots.values()))

    report = run_virtually(
        config,
        look=seen,
        linger_s=linger_s,
        pictures=pictures,
        make_world=lambda *a, **k: _NotedWorld(trace, *a, **k),
    )
    trace.keep(report.to_json(), [body.track() for body in stages[0].bodies])
    return End(report.state, report.duration_s)


def _stage_of(daemon: Daemon) -> Stage:
    names: list[Any] = list(each_camera(daemon.config))
    world: Any = daemon.world
    cameras = [world.cameras[name] for name in names or [None]]
    bodies = list(world.bodies.values())
    return Stage(
        bodies, cameras, world.clock, daemon.people, [name for name in world.bodies if name]
    )


class _NotedWorld(TroubledWorld):
    def __init__(self, trace: Trace, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        self._trace, trace.clock = trace, self.clock
        for number, body in enumerate(self.bodies.values()):
            _hear(body.loop, trace, number)

    def make_link(self, name: str) -> Any:
        number = list(self.bodies).index(name)
        return _NotedLink(super().make_link(name), self._trace, number)


class _NotedLink:
    """A link whose orders are noted before they are carried out."""

    def __init__(self, link: VirtualLink, trace: Trace, robot: int) -> None:
        self._link, self._trace, self._robot = link, trace, robot

    def __getattr__(self, name: str) -> Any:
        member = getattr(self._link, name)
        if name not in CALLS:
            return member
        return self._trace.noted(name, member, "calls", self._robot)


def _hear(loop: VirtualLoop, trace: Trace, robot: int) -> None:
    """Note what the robot hears, from its present boot on."""

    def make(identity: Identity, settings: DriveSettings) -> RobotConnection:
        controller = RobotController(settings)
        for name, words_of in HEARD.items():
            call = getattr(controller.robot, name)
            setattr(controller.robot, name, _noted(call, words_of, loop, trace, robot))
        return RobotConnection(identity, controller)

    loop.make_robot = make
    loop.robot = make(loop.robot.identity, loop.settings)


def _noted(
    call: Callable[..., Any],
    words_of: Callable[..., str],
    loop: VirtualLoop,
    trace: Trace,
    robot: int,
) -> Callable[..., Any]:
    def note_and_call(*given: Any) -> Any:
        trace.note("heard", robot, words_of(loop.robot_s, *given))
        return call(*given)

    return note_and_call


def _waypoints(_now_s: float, data: bytearray, at: int) -> str:
    payload = bytes(data[at : at + 10 + WAYPOINT_BYTES * data[at + 8]])
    return f"accept(message={Waypoints.unpack(payload)!r})"


def _start(now_s: float, data: bytearray, at: int) -> str:
    mission, exec_next = struct.unpack_from("<II", data, at)
    return f"start(mission={mission}, exec_next={exec_next}, now_s={now_s!r})"


def _clear(_now_s: float, data: bytearray, at: int) -> str:
    return f"clear(mission={struct.unpack_from('<I', data, at)[0]})"


def _lease(now_s: float, data: bytearray, at: int) -> str:
    message = Lease.unpack(bytes(data[at : at + Lease.LAYOUT.size]))
    return f"lease(message={message!r}, now_s={now_s!r})"


def _pose(now_s: float, data: bytearray, at: int, _angle: int) -> str:
    message = PoseFix.unpack(bytes(data[at : at + PoseFix.LAYOUT.size]))
    return f"pose_fix(message={message!r}, now_s={now_s!r})"


HEARD: Final[dict[str, Callable[..., str]]] = {
    "open_session": lambda now_s: f"open_session(now_s={now_s!r})",
    "accept": _waypoints,
    "start": _start,
    "pause": lambda _now_s: "pause()",
    "clear": _clear,
    "lease": _lease,
    "see": _pose,
    "emergency_stop": lambda _now_s, why: f"emergency_stop(reason={StopReason(why)!r})",
    "reset_estop": lambda _now_s: "reset_estop()",
}
"""What the line orders the robot to do, and the words for it."""
