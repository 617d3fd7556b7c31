"""The commands of the orders, made from their table."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import click

from navigation.cli.options import SOCKET_OPTION, STATION, StationArgument, format_option
from navigation.orders.table import ORDERS, Order

KNOWN_WITHIN_S = 2.0
"""A robot that hears and brakes is known to stand by then."""
AGAIN_S = 0.1
"""The daemon only answers: nothing reports that the robot is at rest, so it is asked again."""


def _send(path: Path | None, form: str, request: dict[str, Any], robot: str | None) -> None:
    from navigation.control import default_socket, send_order

    if robot is not None:
        request = {**request, "robot": robot}
    answer = send_order(path, request)
    until_s = time.monotonic() + KNOWN_WITHIN_S
    while request["order"] == "stop" and _stops(answer) and time.monotonic() < until_s:
        time.sleep(AGAIN_S)  # a stop may be ordered twice
        answer = send_order(path, request)
    if form == "json":
        click.echo(json.dumps(answer, allow_nan=False))
        return
    for one in answer.get("daemons", [answer]):
        elsewhere = one.get("socket") not in (None, os.path.abspath(path or default_socket()))
        print_state(one, f"the daemon of {one['socket']}: " if elsewhere else "")


def _stops(answer: dict[str, Any]) -> bool:
    from navigation.mission.mission import STOPPING

    robots = [one for daemon in answer.get("daemons", [answer]) for one in _robots_of(daemon)]
    return any(one.get("state") == STOPPING for one in robots)


def _robots_of(answer: dict[str, Any]) -> list[dict[str, Any]]:
    robots = answer.get("robots")
    return [answer, *(robots.values() if isinstance(robots, dict) else ())]


def print_state(answer: dict[str, Any], who: str = "") -> None:
    """Print what the daemon does, and each of several robots."""
    click.echo(f"{who}{answer['state']}: {answer['reason']}")
    if answer.get("trouble"):
        click.echo(f"{who}{answer['trouble']}")
    robots = answer.get("robots")
    if isinstance(robots, dict):
        width = max(map(len, robots))
        for name, one in robots.items():
            click.echo(f"  {name:<{width}}  {one['state']}: {one['waits'] or one['reason']}")


def _command(
    order: Order, callback: Callable[..., None], *, own: Sequence[click.Parameter] = ()
) -> click.Command:
    which = (
        "Which of several robots is meant."
        if order.for_one
        else "Of several robots this one; default: all."
    )
    command = click.Command(
        order.name,
        callback=callback,
        params=[*own, click.Option(["--robot"], metavar="NAME", help=which)],
        help=order.help,
        short_help=order.summary,
        # so that -1.5,2 is a place
        context_settings={"ignore_unknown_options": "stations" in order.arguments},
    )
    SOCKET_OPTION(command)
    format_option()(command)
    return command


def _go(
    stations: tuple[StationArgument, ...],
    dwell_s: float,
    robot: str | None,
    path: Path | None,
    form: str,
) -> None:
    wanted = [
        {"x_m": s.x, "y_m": s.y, "heading_rad": s.heading_rad, "dwell_s": dwell_s} for s in stations
    ]
    _send(path, form, {"order": "go", "stations": wanted}, robot)


def _stop(reason: str, robot: str | None, path: Path | None, form: str) -> None:
    from navigation.control import NoDaemonError, default_socket

    request = {"order": "stop", "reason": reason}
    try:
        _send(path, form, request, robot)
    except NoDaemonError:
        kept = _latch(path, reason, robot)
        try:  # a daemon that has begun to listen meanwhile read the stops before this one
            _send(path, form, request, robot)
        except NoDaemonError:
            sentence = (
                f"no program of yours runs: latched in {kept.parent}; the next run there with the "
                f"socket {os.path.abspath(path or default_socket())} waits until `clearway resume`."
                " A service with a state folder of its own does not: keep it down by "
                "`systemctl disable --now`"
            )
            click.echo(
                json.dumps({"state": "stopped", "reason": sentence}) if form == "json" else sentence
            )


def _latch(path: Path | None, reason: str, robot: str | None) -> Path:
    from navigation.config.last_good import state_folder
    from navigation.control import ControlError, default_socket
    from navigation.journal.stop_latch import FOLDER, Latch, write_latch
    from navigation.orders.arguments import REASON_CHARACTERS, ROBOT_CHARACTERS
    from navigation.shared.outside import printable
    from navigation.shared.whole_file import UnwrittenFileError

    when = datetime.now().isoformat(timespec="milliseconds")
    socket = os.path.abspath(path or default_socket())
    name = printable(robot or "", ROBOT_CHARACTERS)
    latch = Latch(name, printable(reason, REASON_CHARACTERS), when, socket)
    try:
        return write_latch(state_folder(os.environ) / FOLDER, latch)
    except (OSError, UnwrittenFileError) as error:
        raise ControlError(f"no program runs, and the stop cannot be kept: {error}") from None


def _plain(order: Order) -> click.Command:

    def callback(robot: str | None, path: Path | None, form: str) -> None:
        _send(path, form, {"order": order.name}, robot)

    return _command(order, callback)


go = _command(
    ORDERS["go"],
    _go,
    own=(
        click.Argument(["stations"], nargs=-1, required=True, type=STATION),
        click.Option(
            ["--dwell", "dwell_s"],
            type=click.FloatRange(min=0.0),
            default=0.0,
            help="Seconds to stay at each.",
        ),
    ),
)
stop = _command(
    ORDERS["stop"],
    _stop,
    own=(
        click.Option(
            ["--reason"], default="stopped from the command line", help="Shown with the stop."
        ),
    ),
)
commands: Mapping[str, click.Command] = {
    **{
        name: _plain(order)
        for name, order in ORDERS.items()
        if not (order.arguments or order.command)
    },
    "go": go,
    "stop": stop,
}
"""An order that needs arguments has a command of its own, here or elsewhere."""
