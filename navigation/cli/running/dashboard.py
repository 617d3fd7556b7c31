"""`clearway dashboard`: a recording on the page."""

from __future__ import annotations

import os
import threading
import time
from contextlib import closing
from pathlib import Path

import click

from navigation.cli.voice import Voice


@click.command(short_help="A recording on the page, to look at.")
@click.argument("recording", type=click.Path(path_type=Path))
@click.option("--no-browser", is_flag=True, help="Only print the page's address.")
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=0,
    show_default=True,
    help="The page's port on this machine; 0 takes any free one.",
)
def command(recording: Path, no_browser: bool, port: int) -> int:
    """Replay RECORDING (an MCAP file of `clearway run --record`) on the dashboard's page.

    The page is a run's, for one robot or several: picture, obstacles, roadmap, plans, tracks and
    log as recorded, with play, pause, speed and a bar to jump anywhere. Nothing there drives a
    robot. Only this machine can open it. Ctrl-C ends it.
    """
    from navigation.cli.running.demo import browser_here, opening
    from navigation.config.dashboard import DashboardSection
    from navigation.dashboard import Dashboard
    from navigation.dashboard.replay.player import Player
    from navigation.dashboard.replay.replay_hub import ReplayHub
    from navigation.dashboard.replay.replayed_run import ReplayedRun
    from navigation.recording.tape import read_tape

    tape = read_tape(recording)
    voice = Voice()
    cut = ", a file without an end" if tape.recording.cut else ""
    duration_s = tape.end_s - tape.begin_s
    voice.say(f"{recording}: {duration_s:.1f} s, {len(tape.pictures)} pictures{cut}")
    player = Player(duration_s)
    player.seek(time.monotonic(), 0.0)
    say = opening(None if no_browser else browser_here(os.environ), voice.say)
    with (
        closing(ReplayedRun(tape, player, DashboardSection(port=port), time.monotonic)) as run,
        Dashboard(run, say=say, hub=lambda: ReplayHub(run, clock=time.monotonic)) as page,
    ):
        if page.url is None:
            return 1
        threading.Event().wait()  # until Ctrl-C
    return 0
