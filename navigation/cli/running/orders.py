"""`clearway go`, `stop`, `pause`, `resume`, `replan` and `status`: talk to the running daemon."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from navigation.cli.options import STATION, Station, format_option

socket_option = click.option(
    "--socket", "path", type=click.Path(path_type=Path), help="The daemon's socket."
)


def _send(path: Path | None, form: str, request: dict[str, Any]) -> None:
    from navigation.control import default_socket, send_order

    answer = send_order(path or default_socket(), request)
    if form == "json":
        click.echo(json.dumps(answer, allow_nan=False))
        return
    click.echo(f"{answer['state']}: {answer['reason']}")


@click.command(
    short_help="Send the running daemon's robot to a place.",
    context_settings={"ignore_unknown_options": True},  # so that -1.5,2 is a place
)
@click.argument("stations", nargs=-1, required=True, type=STATION)
@click.option(
    "--dwell",
    "dwell_s",
    type=click.FloatRange(min=0.0),
    default=0.0,
    help="Seconds to stay at each.",
)
@socket_option
@format_option()
def go(stations: tuple[Station, ...], dwell_s: float, path: Path | None, form: str) -> None:
    """Drive to X,Y[,DEG], one or several, in metres of the arena."""
    wanted = [
        {"x_m": s.x, "y_m": s.y, "heading_rad": s.heading_rad, "dwell_s": dwell_s} for s in stations
    ]
    _send(path, form, {"order": "go", "stations": wanted})


@click.command(short_help="Emergency stop of the running daemon's robot.")
@click.option("--reason", default="stopped from the command line", help="Shown with the stop.")
@socket_option
@format_option()
def stop(reason: str, path: Path | None, form: str) -> None:
    """Stop the robot at once; it stays stopped until `clearway resume` re-arms it."""
    _send(path, form, {"order": "stop", "reason": reason})


def _plain(name: str, short: str, text: str) -> click.Command:
    @click.command(name, short_help=short, help=text)
    @socket_option
    @format_option()
    def order(path: Path | None, form: str) -> None:
        _send(path, form, {"order": name})

    return order


pause = _plain("pause", "Hold the robot where it is.", "Hold the robot until `clearway resume`.")
resume = _plain(
    "resume",
    "Continue after a pause; re-arm after a stop.",
    "Continue after a pause or a failed mission, with a new plan. After an emergency stop the "
    "first resume re-arms the robot, which does not move yet; a second one continues with the "
    "remaining stations, and `clearway go` gives new ones.",
)
replan = _plain(
    "replan", "Plan the path again.", "Plan the mission again from where the robot is now."
)
status = _plain(
    "status",
    "What the running daemon is doing.",
    "Print what the running daemon is doing, and why.",
)
