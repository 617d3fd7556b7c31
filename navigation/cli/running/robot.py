"""``clearway robot``: a simulated robot on a serial port or on a new pseudo-terminal.

stdout gets the path to open as its first line, then a line whenever the robot's state changes.
"""

from __future__ import annotations

import math
import signal
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import click
import numpy as np

from firmware_protocol.wire.messages import STOP_SENTENCES, RobotState
from navigation.cli.options import STATION, StationArgument
from navigation.config.known_robots import CLEARWAY
from navigation.simulator.line_faults import FaultSpec
from navigation.simulator.robot import SimulatedRobot
from navigation.simulator.shared_pose import PoseWriter
from navigation.simulator.twins.clearway import ClearwayTwin
from navigation.simulator.twins.kinds import TWINS
from navigation.simulator.twins.twin import Twin

LOOK_S = 0.05
TELL_S = 0.002
BY_SIGNAL = 128
"""A shell adds the number of the signal that ended a program."""


@contextmanager
def _linked(link: Path, port: str) -> Iterator[None]:
    """Make a symbolic link, over an old one but over nothing else, and remove it at the end."""
    link.parent.mkdir(parents=True, exist_ok=True)
    if link.is_symlink():
        link.unlink()
    try:
        link.symlink_to(port)
    except FileExistsError:
        raise click.UsageError(f"--link {link}: is there already and is no link") from None
    try:
        yield
    finally:
        # another robot may have taken its place meanwhile
        if link.is_symlink() and str(link.readlink()) == port:
            link.unlink()


@contextmanager
def _signals() -> Iterator[list[int]]:
    """Collect the signals that ask for the end; a second one ends at once."""
    came: list[int] = []

    def ask(number: int, _frame: object) -> None:
        if came:
            raise KeyboardInterrupt
        came.append(number)

    ended_by = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    # an ignored signal, as under nohup, stays ignored
    heard = [number for number in ended_by if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, ask) for number in heard}
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@click.command(help="A simulated robot on a serial port, or on a new pseudo-terminal.")
@click.option(
    "--kind",
    type=click.Choice([CLEARWAY, *TWINS]),
    default=CLEARWAY,
    show_default=True,
    help="What it speaks: Clearway's own line, or another maker's protocol, byte for byte.",
)
@click.option(
    "--port", metavar="PATH", help="Serial port to use; without it a new pseudo-terminal is made."
)
@click.option(
    "--faults",
    metavar="SPEC",
    default="",
    callback=lambda _ctx, _param, text: FaultSpec.parse(text),
    help="Bad line: drop=0.001,flip=0.0005,noise=P,dup=P,swap=P,span=P,stall=0.1@5,"
    "reset=SECONDS,freeze=0.2@10.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Seed of the robot's errors and the line's faults.",
)
@click.option(
    "--start",
    type=STATION,
    default="0,0,0",
    show_default=True,
    help="Where the robot is, in metres and degrees.",
)
@click.option(
    "--baud",
    type=click.IntRange(1200, 4_000_000),
    help="Bits a second; a pseudo-terminal is paced to it. Without it as the robot has it.",
)
@click.option(
    "--link",
    type=click.Path(path_type=Path),
    help="Also make a link to the new pseudo-terminal, as long as the robot runs.",
)
@click.option(
    "--poses",
    type=click.Path(path_type=Path),
    help="Write the pose to this file, for simulation.robot.poses of a run.",
)
def command(
    kind: str,
    port: str | None,
    faults: FaultSpec,
    seed: int,
    start: StationArgument,
    baud: int | None,
    link: Path | None,
    poses: Path | None,
) -> int:
    """Run the robot until a signal ends it."""
    rng = np.random.default_rng(seed)
    with ExitStack() as until:
        ended = until.enter_context(_signals())
        told_in = None if poses is None else until.enter_context(closing(PoseWriter(poses)))
        twin: Twin = ClearwayTwin() if kind == CLEARWAY else TWINS[kind]()
        pose = (start.x, start.y, start.heading_rad or 0.0)
        robot = SimulatedRobot(pose, twin=twin, rng=rng, faults=faults, port=port, baud=baud)
        until.enter_context(robot)
        click.echo(robot.port)
        if link is not None:
            until.enter_context(_linked(link, robot.port))
        told: tuple[object, ...] = ()
        while not ended:
            news, words = news_of(robot)
            if news != told:
                told = news
                click.echo(words)
            if told_in is not None:
                told_in.write(*robot.pose())
            # the robot lives in its own thread: this one only watches
            time.sleep(LOOK_S if told_in is None else TELL_S)  # the pace of its reports
    return BY_SIGNAL + ended[0]


def news_of(robot: SimulatedRobot) -> tuple[tuple[object, ...], str]:
    """Facts worth a line when they change, and the line."""
    at = _place(*robot.pose())
    if not isinstance(robot.twin, ClearwayTwin):
        words = "its wheels turn" if robot.moving else "its wheels are at rest"
        return (robot.moving,), f"{words}, at {at}"
    with robot.held:
        control = robot.twin.controller
        state, reason, mission = control.state, control.reason, control.mission
        executed = control.exec_next
    why = "" if state is RobotState.RUN else f": {STOP_SENTENCES[reason]}"
    words = f"{state.name}{why}; mission {mission:#x}, {executed} executed, at {at}"
    return (state, reason, mission), words


def _place(x_m: float, y_m: float, heading_rad: float) -> str:
    return f"({x_m:.3f}, {y_m:.3f}) m, {math.degrees(heading_rad):.1f} deg"
