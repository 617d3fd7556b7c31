"""`clearway run`: the daemon on one configuration."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from navigation.cli.options import OUTPUT, RecordingType
from navigation.cli.voice import Voice, complain

if TYPE_CHECKING:
    from navigation.config import Config
    from navigation.dashboard.settings.desk import Desk
    from navigation.machine.logs import EventLog, Level
    from navigation.run.run_report import RunReport
    from navigation.run.runner import Runner


@click.command(short_help="Drive the robot: camera, planning, serial link.")
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--once", is_flag=True, help="End when the configured mission is over.")
@click.option("--report", type=OUTPUT, help="Write the report here too.")
@click.option(
    "--record",
    type=RecordingType(),
    metavar="FILE.mcap|DIR",
    help="Record pictures, scenes, plans and poses into the new FILE.mcap, or into MCAP files in "
    "DIR, the oldest of which go at recording.limit_mb.",
)
@click.option("--no-dashboard", is_flag=True, help="Do not serve the dashboard.")
@click.option(
    "--socket",
    type=click.Path(path_type=Path),
    help="Where to listen for orders; default: one per user.",
)
@click.option("--quiet", is_flag=True, help="Print the report only.")
@click.option("--last-good", is_flag=True, help="If CONFIG is invalid, run the last good one.")
@click.option(
    "--log-format", type=click.Choice(["text", "json"]), help="Log events, a line each, to stderr."
)
@click.option(
    "--log-level",
    type=click.Choice(["debug", "info", "warning", "error"]),
    default="info",
    show_default=True,
    help="The lowest level that is logged.",
)
def command(
    config: Path,
    once: bool,
    report: Path | None,
    record: Path | None,
    no_dashboard: bool,
    socket: Path | None,
    quiet: bool,
    last_good: bool,
    log_format: Literal["json", "text"] | None,
    log_level: Level,
) -> int:
    """Run the configuration CONFIG: see the arena, plan, and drive the robot.

    Without --once the program keeps running after the mission until interrupted. A folder in
    recording.runs_dir keeps the report and a picture of the run. Exits 0 when the mission was done,
    3 when there was no path, 1 when it failed or was stopped; without --once an interrupt is the
    ordinary end, with code 0. SIGHUP reads CONFIG again: a valid file is run; otherwise all errors
    are reported.
    """
    from navigation.machine.descriptors import set_descriptor_limit
    from navigation.machine.logs import EventLog

    set_descriptor_limit()
    voice = Voice(quiet=quiet)
    log = EventLog(
        sys.stderr,
        log_format,
        now=datetime.now,
        level=log_level,
        priorities="JOURNAL_STREAM" in os.environ,
    )
    loaded: Config | None = load_or_go_back(config, last_good, log)
    # after the configuration: a refused one need not wait a second for the kernels' compiler
    from navigation.config.last_good import state_folder
    from navigation.config.several.each_robot import settled
    from navigation.journal.stop_latch import FOLDER
    from navigation.machine.sd_notify import Notifier, watchdog_period_s
    from navigation.run.runner import Runner
    from navigation.shared.whole_file import UnwrittenFileError

    log.write("info", "started", config=str(config), version=version("clearway"))
    notifier = Notifier.from_environment(os.environ)
    waits, zones = False, None
    while loaded is not None:
        loaded = settled(loaded)
        runner = Runner(
            loaded,
            once=once,
            file=config,
            say=voice.say,
            socket=socket,
            record=record,
            dashboard=not no_dashboard,
            show_token=sys.stdout is not None
            and sys.stdout.isatty(),  # a log that others read must not have it
            log=log,
            notifier=notifier,
            watchdog_s=watchdog_period_s(os.environ),
            stops=state_folder(os.environ) / FOLDER,
        )
        reload = _Reload(config, loaded, runner, log)
        runner.waits, runner.zones = waits, zones
        if not no_dashboard:
            runner.desk = _desk(config, reload)
        with signals_heard(runner, reload):
            result = runner.run()
        loaded, waits, zones = reload.fresh, reload.reloader.waits, runner.zones
    if report is not None:
        try:
            result.report.write(report)
        except UnwrittenFileError as error:
            complain(f"clearway: {error}")
    show(voice, result.report, str(result.folder or "nothing: no room"))
    return result.exit_code


def load_or_go_back(file: Path, last_good: bool, log: EventLog) -> Config:
    """The configuration; if it is broken and ``last_good`` is set, the kept one, with a message.

    A good configuration is kept for the next time. ``ConfigError`` says how to go back.
    """
    from navigation.cli.setup.check import load_checked
    from navigation.config.errors import ConfigError
    from navigation.config.last_good import LastGood, state_folder
    from navigation.config.load import read_source

    kept = LastGood(file, state_folder(os.environ))
    try:
        config = load_checked(file)
    except ConfigError as error:
        advice = kept.advice()
        if advice is None:
            raise
        if not last_good:
            raise error.with_advice(advice) from None
        complain(f"clearway: {error}\n{advice}\nclearway: running {kept.kept}")
        log.write("error", "configuration", file=str(file), running=str(kept.kept))
        return kept.load(os.environ)
    problem = kept.keep(read_source(file))
    if problem is not None:
        log.write("warning", "configuration", reason=f"no copy could be kept: {problem}")
    return config


def _desk(config: Path, reload: _Reload) -> Desk:
    from navigation.cli.setup.check import file_problems
    from navigation.cli.setup.devices import cameras_here, serial_ports
    from navigation.config.last_good import state_folder
    from navigation.dashboard.settings.desk import Around, Desk

    return Desk(
        Around(
            file=config,
            state=state_folder(os.environ),
            environment=os.environ,
            file_problems=file_problems,
            devices=lambda: (
                [camera["path"] for camera in cameras_here()],
                [port["path"] for port in serial_ports()],
            ),
            reload=reload.ask_from_the_page,
        )
    )


class _Reload:
    """Action of SIGHUP and the page: read the file, and end the run if it has changed."""

    def __init__(self, file: Path, present: Config, runner: Runner, log: EventLog) -> None:
        from navigation.run.reload import Reloader

        self.fresh: Config | None = None
        self._runner, self._log = runner, log
        self.reloader = Reloader(
            file,
            present,
            load=lambda path: load_or_go_back(path, False, log),
            say=self._say,
            good=self._restart,
        )
        runner.reload = self.reloader.ask
        runner.reload_and_wait = self.ask_from_the_page

    def ask(self) -> None:
        """Read the file soon, and begin again as at the start."""
        self.reloader.ask()

    def ask_from_the_page(self) -> None:
        """Read the file soon, and begin again without driving anywhere."""
        self.reloader.ask(waits=True)

    def _say(self, level: Level, sentence: str) -> None:
        complain(f"clearway: {sentence}")
        self._log.write(level, "configuration", reason=sentence)

    def _restart(self, config: Config) -> None:
        self.fresh = config
        self._runner.interrupt_reason = "the configuration has changed"
        self._runner.interrupt.set()


def show(voice: Voice, report: RunReport, kept_in: str) -> None:
    """Print the report, and where it is kept."""
    width = max(len(label) for label, _ in report.lines())
    voice.tell("")
    for label, value in report.lines():
        voice.tell(f"  {label:<{width}}  {value}")
    voice.tell(f"  {'kept in':<{width}}  {kept_in}")


@contextmanager
def signals_heard(runner: Runner, reload: _Reload | None = None) -> Iterator[None]:
    """End the run in order on Ctrl-C or SIGTERM, at once on a second; read CONFIG again on SIGHUP.

    Without ``reload`` there is no CONFIG to read: SIGHUP, as of a closed terminal, ends the run.
    """

    def ask(number: int, _frame: object) -> None:
        again = runner.interrupt.is_set() and (reload is None or reload.fresh is None)
        if reload is not None:
            reload.fresh = None
        runner.interrupt.set()
        if again or runner.is_warming_up:
            raise KeyboardInterrupt

    def read_again(number: int, frame: object) -> None:
        if reload is None:
            ask(number, frame)
        else:
            reload.ask()

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    before[signal.SIGHUP] = signal.signal(signal.SIGHUP, read_again)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
