"""``calibrate --live`` from its options to its views: the displays, and the words at the end."""

from __future__ import annotations

import sys
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from navigation.cli.calibrating.page import LivePage
    from vision.calibrate.board import BoardSpec, BoardView
    from vision.calibrate.live.taking import LiveTaken, Shows


def taken_live(
    source: str, spec: BoardSpec, limit_px: float | None, page: int | None
) -> list[BoardView]:
    """Take views from a camera, shown in the terminal and, at the port ``page``, on a page.

    Raises ``CalibrationError`` if there are too few views.
    """
    from rich.console import Console

    from navigation.cli.calibrating.live import live_camera
    from navigation.cli.calibrating.page import LivePage
    from navigation.cli.calibrating.terminal import TerminalLines, TerminalTable
    from vision.calibrate.live.session import LIMIT_PX, LiveSession
    from vision.calibrate.live.taking import take_live

    session = LiveSession(spec, LIMIT_PX if limit_px is None else limit_px)
    camera = live_camera(source, spec, session, time.monotonic, time.sleep)
    with ExitStack() as stack:
        shows: list[Shows] = []
        if page is not None:
            shows.append(stack.enter_context(_opened(LivePage, page)))
        click.echo(f"{camera.name}: hold the board before it; Ctrl-C ends it", err=True)
        console = Console(stderr=True)
        if console.is_terminal:
            shows.append(stack.enter_context(TerminalTable(console)))
        else:
            shows.append(TerminalLines(sys.stderr))
        taken = take_live(camera, spec, session, shows, time.monotonic)
        sentence = said_at_the_end(taken)
        for one in shows:
            if isinstance(one, LivePage):
                one.end(sentence)
    click.echo(sentence, err=True)
    refuse_too_few(taken)
    return list(taken.views)


def _opened(make: type[LivePage], port: int) -> LivePage:
    try:
        page = make(port)
    except OSError as error:
        raise click.UsageError(f"--page {port}: {error.strerror or error}") from error
    click.echo(f"page at {page.url}", err=True)
    return page


def said_at_the_end(taken: LiveTaken) -> str:
    """Reason for the end, and the result."""
    from navigation.dashboard.calibrating.said import cells_line, known_line

    if taken.last is None:
        return f"{taken.ended}: there was no picture"
    if not taken.views:
        return f"{taken.ended}: no view was taken"
    known = f"{cells_line(taken.last)}; {known_line(taken.last)}"
    return f"{taken.ended}: {len(taken.views)} views, {known}"


def refuse_too_few(taken: LiveTaken) -> None:
    """``CalibrationError`` if the views are too few for a lens."""
    from vision.calibrate.lens import MIN_VIEWS
    from vision.calibration.calibration import CalibrationError

    if len(taken.views) < MIN_VIEWS:
        raise CalibrationError(
            f"{len(taken.views)} views of the board were taken, at least {MIN_VIEWS} are needed: "
            "nothing is written"
        )
