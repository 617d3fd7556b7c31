"""`clearway demo`: a simulated run with its dashboard."""

from __future__ import annotations

import os
import sys
import tempfile
import threading
from collections.abc import Callable, Mapping
from pathlib import Path

import click

from navigation.cli.voice import Voice

ADDRESS = "dashboard at "


@click.command(short_help="A simulated arena and its dashboard, without any file.")
@click.option("--once", is_flag=True, help="End when the mission is over.")
@click.option("--no-browser", is_flag=True, help="Only print the dashboard's address.")
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=0,
    show_default=True,
    help="The dashboard's port; 0 takes any free one.",
)
def command(once: bool, no_browser: bool, port: int) -> int:
    """Show a simulated arena: the robot drives, the dashboard opens in the browser.

    Camera, arena and robot are simulated; vision, planning, the serial link and the dashboard are
    real. Nothing is kept. Click in the arena to see the path there, then press "Send the robot";
    Ctrl-C ends it.
    """
    from navigation.cli.running.run import show, signals_heard
    from navigation.cli.setup.starter_values import demo_values
    from navigation.config.load import parse_config
    from navigation.config.reference import starter_yaml
    from navigation.machine.descriptors import set_descriptor_limit
    from navigation.run.runner import Runner

    set_descriptor_limit()
    voice = Voice()
    with tempfile.TemporaryDirectory(prefix="clearway-demo-") as folder:
        kept = {"recording": {"runs_dir": folder}, "dashboard": {"port": port}}
        config = parse_config(starter_yaml({**demo_values(), **kept}, "demo"), "demo", Path(folder))
        browser = None if no_browser else browser_here(os.environ)
        runner = Runner(
            config,
            once=once,
            say=opening(browser, voice.say),
            socket=Path(folder) / "socket",
            show_token=sys.stdout is not None and sys.stdout.isatty(),
        )
        with signals_heard(runner):
            result = runner.run()
        show(voice, result.report, "nothing: this was a demonstration")
    return result.exit_code


def browser_here(environment: Mapping[str, str]) -> Callable[[str], object] | None:
    """Function that opens an address in a browser; None without a screen or browser.

    Over SSH a browser would open on the wrong machine, or in the terminal.
    """
    import webbrowser

    screen = environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY")
    if environment.get("SSH_CONNECTION") or (sys.platform == "linux" and not screen):
        return None
    try:
        return webbrowser.get().open
    except webbrowser.Error:
        return None


def opening(
    browser: Callable[[str], object] | None, say: Callable[[str], None]
) -> Callable[[str], None]:
    """``say``, which also gives the dashboard's address to the browser."""

    def say_and_open(line: str) -> None:
        say(line)
        if browser is not None and line.startswith(ADDRESS):
            # a slow browser must not hold up the run
            address = line.removeprefix(ADDRESS).strip()
            threading.Thread(target=browser, args=(address,), daemon=True).start()

    return say_and_open
