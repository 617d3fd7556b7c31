"""`clearway run`: the daemon on one configuration, with its progress and its report."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from navigation.cli.options import OUTPUT

if TYPE_CHECKING:
    from navigation.report import Report

PROGRESS_EVERY_S = 1.0


@click.command(short_help="Drive the robot: camera, planning, serial link.")
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--once", is_flag=True, help="End when the configured mission is over.")
@click.option("--report", type=OUTPUT, help="Write the report here too.")
@click.option(
    "--record",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Record pictures, scenes, plans and poses into MCAP files in DIR.",
)
@click.option("--no-dashboard", is_flag=True, help="Do not serve the dashboard.")
@click.option(
    "--socket", type=click.Path(path_type=Path), help="Where to take orders; default: per user."
)
@click.option("--quiet", is_flag=True, help="Print the report only.")
def command(
    config: Path,
    once: bool,
    report: Path | None,
    record: Path | None,
    no_dashboard: bool,
    socket: Path | None,
    quiet: bool,
) -> int:
    """Run the configuration CONFIG: see the arena, plan, and drive the robot.

    Without --once the program goes on after the mission until it is interrupted. A folder in
    recording.runs_dir keeps the report and a picture of what happened. Exits 0 when the
    mission was done, 3 when there was no path, 1 when it failed or was stopped.
    """
    from navigation.cli.check import load_checked
    from navigation.runner import Runner

    loaded = load_checked(config)
    say = _say if not quiet else _say_nothing
    runner = Runner(
        loaded,
        once=once,
        say=say,
        socket=socket,
        record=record,
        dashboard=not no_dashboard,
        show_token=sys.stdout.isatty(),  # a log that others read must not have it
    )
    with _interrupts(runner.interrupt):
        result = runner.run()
    if report is not None:
        result.report.write(report)
    _show(result.report, result.folder)
    return result.exit_code


def _say(line: str) -> None:
    click.echo(line)


def _say_nothing(_line: str) -> None:
    pass


def _show(report: Report, folder: Path) -> None:
    width = max(len(label) for label, _ in report.lines())
    click.echo()
    for label, value in report.lines():
        click.echo(f"  {label:<{width}}  {value}")
    click.echo(f"  {'kept in':<{width}}  {folder}")


@contextmanager
def _interrupts(interrupt: threading.Event) -> Iterator[None]:
    """Ctrl-C and SIGTERM end the run in order; a second one ends it at once."""

    def ask(number: int, _frame: object) -> None:
        if interrupt.is_set():
            raise KeyboardInterrupt
        interrupt.set()

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
