"""One run from its warm-up to its report."""

from __future__ import annotations

import errno
import math
import os
import random
import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from navigation.config import Config
from navigation.config.secrecy.secrets import hide
from navigation.config.several.each_camera import each_camera
from navigation.config.several.each_robot import robots_of
from navigation.config.values import SIMULATED
from navigation.control import default_socket
from navigation.journal.kept_stops import KeptStops
from navigation.journal.stop_latch import ports_of
from navigation.link.serial_port import PortNotReadyError, look_for_port
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.loop.zones_in_force import ZonesInForce
from navigation.machine.logs import EventLog, RunLog
from navigation.machine.sd_notify import Notifier, Watchdog
from navigation.mission.mission import State
from navigation.recording.names import place_of
from navigation.run.anchoring import renew_while_running, take_over_lens
from navigation.run.attendance import Attendance
from navigation.run.devices.world_clock import slowness
from navigation.run.give_missions import GiveMissions
from navigation.run.journals import open_journals
from navigation.run.kernels.warm_up import warm_up
from navigation.run.notifications import Notifications
from navigation.run.progress import ProgressLines, why_stopped
from navigation.run.restoring_zones import RestoredZones
from navigation.run.run_folder import make_run_folder, prepare_picture, write_report, write_run
from navigation.run.run_report import RunReport, summarise_run
from navigation.run.taking_orders import TakingOrders
from navigation.run.world import World
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame, Image

if TYPE_CHECKING:
    from navigation.dashboard import Dashboard
    from navigation.dashboard.settings.desk import Desk
    from navigation.loop.recorder import Recorder
    from vision.calibrate.lens import Lens

DONE, FAILED, NO_PATH = 0, 1, 3
NO_ROOM = frozenset((errno.ENOSPC, errno.EDQUOT, errno.EFBIG))
"""The disk, or the share of it, is full."""
EVENTS_FILE = "events.jsonl"


@dataclass(frozen=True, slots=True)
class RunResult:
    """Report, folder and exit code; ``folder`` is None if the disk had no space."""

    report: RunReport
    folder: Path | None
    exit_code: int


class Runner:
    """Runner of a configuration; ``say`` gets a line for each piece of news.

    Setting ``interrupt`` ends the run in order: the robot stops first. While ``is_warming_up``
    there is no robot yet, and a KeyboardInterrupt may be raised in it. With ``show_token`` the
    printed address includes its token; the program's own token is printed without it too, but not
    into the system's journal. ``log`` gets every event. ``notifier`` reports to systemd: ready,
    stopping and, at least every ``watchdog_s``, healthy. ``file`` is the configuration's source,
    the owner of missions in the journal; orders may name masks in its folder. ``stops`` is the
    folder of stops that outlive a run; without it none do.
    """

    def __init__(  # noqa: PLR0913 (what a command gives a run, each with a default)
        self,
        config: Config,
        *,
        once: bool,
        file: Path | None = None,
        say: Callable[[str], None],
        socket: Path | None = None,
        record: Path | None = None,
        dashboard: bool = True,
        show_token: bool = False,
        log: EventLog | None = None,
        notifier: Notifier | None = None,
        watchdog_s: float | None = None,
        stops: Path | None = None,
    ) -> None:
        self.config = config
        self._robots = robots_of(config)
        self.interrupt = threading.Event()
        self._once, self._file = once, file
        self._socket, self._stops, self._record = socket, stops, record
        self._dashboard = dashboard and config.dashboard.enabled
        self._show_token = show_token
        self._log = RunLog(log or EventLog(sys.stderr, None, now=datetime.now))
        self._notifier = notifier or Notifier(None)
        self._watchdog_s = watchdog_s
        self.interrupt_reason = "interrupted"
        self.desk: Desk | None = None
        """Desk for the page's changes of the configuration; set before `run`."""
        self.waits = False
        """For orders, instead of driving the configured mission."""
        self.zones: ZonesInForce | None = None  # of the run before, then of this one
        self.is_warming_up = False
        self.reload: Callable[[], None] | None = None
        """Reads the configuration and its calibration again; None where nothing was read."""
        self.reload_and_wait: Callable[[], None] | None = None
        """The same, and the run that begins again waits for orders."""
        self._say: Callable[[str], None] = lambda line: say(hide(line))
        self._say_as_it_is = say

    def run(self) -> RunResult:
        """Run until all missions are over (``once``), the time limit, or an interrupt."""
        self._refuse_what_is_no_port()  # before the user has waited for the kernels
        with ExitStack() as open_things:
            journals = open_journals(  # first: a second program is refused here
                self.config, self._robots, self._file, open_things, self._warn
            )
            folder = self._open_folder(open_things)
            if not self._warm_up():
                return self._end_before_the_start(folder)
            # before the world: at the end its last calls do not keep cameras and ports
            notifications = open_things.enter_context(
                Notifications(self.config.notify, self._log, self._say, datetime.now)
            )
            world = World(self.config, wait_for_port=not self._once)
            seen_by = camera_words(self.config)
            ports = {name or "robot": f"on {port}" for name, port in world.ports.items()}
            self._say(", ".join((seen_by, *map(" ".join, ports.items()))))
            socket = self._socket or default_socket()
            recorder = self._open_recorder(open_things, world.calibration, world.clock)
            first_id = random.SystemRandom().randrange(1, 1 << 32)
            daemon = open_things.enter_context(
                Daemon(
                    self.config,
                    world,
                    first_mission_id=first_id,
                    journals=journals,
                    recorder=recorder,
                )
            )
            zones = RestoredZones(daemon, self._say, self._log, self.zones)
            self.zones = daemon.zones
            daemon.people.reanchor = lambda camera: self.reanchor(camera, daemon.newest)
            daemon.people.masks_in = None if self._file is None else self._file.absolute().parent
            open_things.callback(daemon.stopping.end)  # once no more orders are taken
            taking = TakingOrders(open_things, socket, daemon, self._log, self._say)
            named = " --robot NAME" if self.config.robots else ""
            self._say(f"orders at {socket}: clearway go X,Y{named}, stop, pause, resume, status")
            page = self._serve_dashboard(daemon, open_things, socket, folder)
            # after orders are taken: earlier stops are on the disk, new ones arrive here
            self._hold_what_was_stopped(daemon, socket)
            zones.settle()
            missions = GiveMissions(daemon, self._say, for_orders=self.waits)
            self._notifier.send("READY=1")
            self._log.write(
                "info", "ready", camera=seen_by.partition(" ")[2], port=_port_words(world)
            )
            open_things.callback(self._notifier.send, "STOPPING=1")
            state, reason = self._drive(daemon, missions, recorder, taking, notifications)
            daemon.halt()
            notifications.end(state, reason)
            # while the robots brake
            if page is not None and self.interrupt.is_set():
                page.begin_closing()
            prepare_picture(daemon)
            doubts = daemon.let_the_robots_stop()
            duration_s = world.clock() - daemon.started_s
            report = summarise_run(daemon, state, reason, duration_s)
            # before the simulation ends, and with it the tracks of simulated robots
            unwritten = [] if folder is None else write_run(folder, daemon, report)
            self._log_end(report)
        for trouble in (*doubts, *world.doubts, *unwritten):
            self._say(f"trouble: {trouble}")
        for remark in slowness(world.clock):
            self._say(remark)
        if recorder is not None:
            self._say(recorder.summary())
        return RunResult(report, folder, self._exit_code(state, daemon))

    def _log_end(self, report: RunReport) -> None:
        self._log.write(
            "info",
            "finished",
            state=report.state,
            reason=report.reason,
            duration_s=report.duration_s,
        )

    def _warm_up(self) -> bool:
        """True unless interrupted."""
        self.is_warming_up = True
        try:
            warm_up(self.config, self._say)
        except KeyboardInterrupt:
            if not self.interrupt.is_set():
                raise
        finally:
            self.is_warming_up = False
        return not self.interrupt.is_set()

    def _end_before_the_start(self, folder: Path | None) -> RunResult:
        stations = {name: len(stations_of(one)) for name, one in self._robots.items()}
        reason = f"{self.interrupt_reason} before anything was driven"
        report = RunReport.of_nothing(reason, stations)
        self._log_end(report)
        for trouble in () if folder is None else write_report(folder, report):
            self._say(f"trouble: {trouble}")
        has_missions = any(stations.values()) or bool(self.config.tasks)
        return RunResult(report, folder, FAILED if self._once and has_missions else DONE)

    def _refuse_what_is_no_port(self) -> None:
        """Raise ``PortError`` if waiting cannot help, or with ``once`` if a port is not ready."""
        for one in self._robots.values():
            if one.serial.port == SIMULATED:
                continue
            try:
                look_for_port(one.serial.port)
            except PortNotReadyError:
                if self._once:
                    raise
                # else the link opens it once it can, and reports until then

    def _serve_dashboard(
        self,
        daemon: Daemon,
        open_things: ExitStack,
        socket: Path,
        folder: Path | None,
    ) -> Dashboard | None:
        if not self._dashboard:
            return None
        # imported here: a run without a page need not load a web server
        from navigation.dashboard import Bench, Dashboard, KeptRuns
        from navigation.dashboard.admission.own_token import token_of_run

        bench = Bench(
            daemon,
            self.config,
            daemon.world.calibration,
            self.take_over_lens,
            daemon.world.clock,
            daemon.world.wait,
        )
        open_things.callback(bench.close)
        token = None
        if self.config.dashboard.token is None:
            token = token_of_run(socket.with_name(f"{socket.name}.token"), self._say)
        in_journal = "JOURNAL_STREAM" in os.environ
        shows_token = self._show_token or (token is not None and not in_journal)
        return open_things.enter_context(
            Dashboard(
                daemon,
                say=self._say_as_it_is if shows_token else self._say,
                clock=daemon.world.clock,
                own_token=token,
                show_token=shows_token,
                desk=self.desk,
                bench=bench,
                runs=KeptRuns(
                    self.config.recording.runs_dir,
                    place_of(self._record, self.config.recording.folder)[0],
                    None if folder is None else folder.name,
                ),
            )
        )

    def _warn(self, robot: str, sentence: str) -> None:
        self._log.write("warning", "trouble", reason=sentence)
        self._say(f"{robot}: {sentence}" if robot else sentence)

    def _open_folder(self, open_things: ExitStack) -> Path | None:
        runs_dir = self.config.recording.runs_dir
        try:
            folder = make_run_folder(runs_dir, datetime.now())
        except OSError as error:
            if error.errno not in NO_ROOM:
                where = f"recording.runs_dir = {runs_dir}"
                raise OSError(error.errno, error.strerror, where) from None
            self._say(f"trouble: {runs_dir}: {error.strerror}; the run keeps no report there")
            return None
        events = EventLog.to_file(folder / EVENTS_FILE, now=datetime.now)
        self._log.logs.append(open_things.enter_context(closing(events)))
        return folder

    def _open_recorder(
        self, open_things: ExitStack, calibration: Calibration, clock: Callable[[], float]
    ) -> Recorder | None:
        settings = self.config.recording
        if self._record is None and not settings.record:
            return None
        from navigation.loop.recorder import Recorder  # only a run that records needs its libraries

        folder, file = place_of(self._record, settings.folder)
        began = datetime.now()
        recorder = Recorder(self.config, calibration, folder, file=file, clock=clock, began=began)
        open_things.enter_context(recorder)
        self._say(f"recording into {recorder.path}")
        return recorder

    def _hold_what_was_stopped(self, daemon: Daemon, socket: Path) -> None:
        if self._stops is None:
            return
        ports = {name: ports_of(one.serial.port) for name, one in self._robots.items()}
        kept = KeptStops(self._stops, socket, self._file, ports)
        robots = list(daemon.robots.values())
        for name, sentence in daemon.stopping.hold_from_before(robots, kept).items():
            self._say(f"{name}: {sentence}" if name else sentence)
            self._log.write("warning", "stopped", robot=name, reason=sentence)

    def _drive(
        self,
        daemon: Daemon,
        missions: GiveMissions,
        recorder: Recorder | None,
        taking: TakingOrders,
        notifications: Notifications,
    ) -> tuple[State, str]:
        limit_s, give_up_s = self._time_limit_s(), self.config.safety.give_up_s
        watchdog = Watchdog(self._notifier, self._watchdog_s, daemon.turns)
        attendance = Attendance(daemon, self._log, watchdog, recorder, self._say)
        lines = ProgressLines(self._say, lambda line: self._notifier.send(f"STATUS={line}"))
        while True:
            missions.cycle()
            now = daemon.cycle()
            lines.cycle(now)
            taking.cycle()
            attendance.cycle(now, time.monotonic())
            notifications.cycle(now)
            if self.interrupt.is_set():
                return State.STOPPED, self.why_interrupted(why_stopped(now))
            waits = daemon.stopping.waits_for_rearm
            has_met = waits or daemon.has_met_its_devices
            if self._once and now.time_s > give_up_s and not has_met:
                reason = f"given up after {give_up_s:g} s without robot and camera"
                return State.FAILED, f"{reason}: {now.sentence}"
            if now.time_s > limit_s:
                return State.FAILED, f"not done within {limit_s:g} s: {now.sentence}"
            if self._once and not waits and missions.are_given and now.is_over:
                return now.state, now.sentence

    def why_interrupted(self, stopped: str | None) -> str:
        """Reason of an interrupted run, after an emergency stop's cause."""
        return f"{stopped}; then {self.interrupt_reason}" if stopped else self.interrupt_reason

    def _exit_code(self, state: State, daemon: Daemon) -> int:
        interrupted = self.interrupt.is_set()
        if state is State.DONE or (interrupted and not self._once):
            return DONE  # a run that continues after its mission ends only by an interrupt
        pilots = [one.pilot for one in daemon.robots.values()]
        if any(pilot.no_path for pilot in pilots):
            return NO_PATH
        had_missions = bool(self.config.tasks) or any(pilot.mission.stations for pilot in pilots)
        return FAILED if had_missions or not interrupted else DONE

    def reanchor(
        self, camera: str | None, newest: Callable[[str | None], Frame | None]
    ) -> list[str]:
        """Place a camera again from its newest picture and report, or ``MissionError``."""
        lines = renew_while_running(self.config, camera, newest, self.reload)
        self._log.write("warning", "anchoring", reason="; ".join(lines))
        return lines

    def take_over_lens(self, lens: Lens, picture: Image | None) -> str:
        """Save a new lens and begin again with it; ``ValueError`` on failure."""
        said = take_over_lens(self.config, lens, picture, datetime.now(), self.reload_and_wait)
        self._log.write("warning", "calibration", reason=said)
        return said

    def _time_limit_s(self) -> float:
        simulation = self.config.simulation
        return math.inf if simulation is None or not self._once else simulation.time_limit_s


def _port_words(world: World) -> str:
    named = (f"{name} on {port}" if name else port for name, port in world.ports.items())
    return ", ".join(named)


def camera_words(config: Config) -> str:
    """The camera, or each with its name, as printed."""
    named = [f"{name} {one.camera.source}" for name, one in each_camera(config).items()]
    return f"cameras {', '.join(named)}" if named else f"camera {config.camera.source}"
