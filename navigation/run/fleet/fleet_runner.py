"""One run of several robots from its beginning to its report.

Units: metres, radians, seconds.
"""

from __future__ import annotations

import random
import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from navigation.config import Config
from navigation.config.sections import SIMULATED
from navigation.config.several.each_robot import each_robot
from navigation.control import default_socket
from navigation.draw import DrawError
from navigation.journal.journal import Journal, owner_of
from navigation.link.serial_port import PortNotReadyError, look_for_port
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.machine.sd_notify import Watchdog
from navigation.mission.mission import State
from navigation.run.attendance import Attendance
from navigation.run.devices.world_clock import slowness
from navigation.run.fleet.fleet_lines import FleetLines, why_stopped
from navigation.run.fleet.fleet_picture import write_picture
from navigation.run.fleet.fleet_report import FleetReport, summarise_fleet
from navigation.run.fleet.fleet_warm_up import warm_up_fleet
from navigation.run.fleet.fleet_world import FleetWorld
from navigation.run.fleet.give_missions import GiveMissions
from navigation.run.runner import DONE, FAILED, NO_PATH, Runner
from navigation.run.taking_orders import TakingOrders
from navigation.run.trouble_lines import troubles_of
from navigation.run.world import camera_words
from navigation.shared.whole_file import UnwrittenFileError

if TYPE_CHECKING:
    from navigation.loop.recorder import Recorder


class FleetRunner(Runner):
    """Runs a configuration of several robots; its arguments are the runner's of one."""

    def run_fleet(self) -> tuple[FleetReport, Path | None, int]:
        """Until all missions are over (``once``), the time limit, or an interrupt.

        The report, the run's folder (None: there was no room for one) and the exit code.
        """
        self._refuse_what_is_no_port()
        with ExitStack() as open_things:
            journals = self._open_journals(open_things)
            folder = self._open_folder(open_things)
            if not self._warm_up():
                report = _of_nothing(self.config, f"{self.interrupt_reason} before anything moved")
                self._write(folder, report)
                has_missions = any(map(stations_of, each_robot(self.config).values()))
                failed = self._once and (has_missions or bool(self.config.tasks))
                return report, folder, FAILED if failed else DONE
            warm_up_fleet(self.config)
            world = FleetWorld(self.config, wait_for_port=not self._once)
            ports = ", ".join(f"{name} on {port}" for name, port in world.ports.items())
            seen_by = camera_words(self.config)
            self._say(f"{seen_by}, {ports}")
            first_id = random.SystemRandom().randrange(1, 1 << 32)
            recorder = self._open_recorder(open_things, world.calibration, world.clock)
            daemon = open_things.enter_context(
                Daemon(
                    self.config,
                    world,
                    first_mission_id=first_id,
                    journals=journals,
                    recorder=recorder,
                )
            )
            socket = self._socket or default_socket()
            daemon.people.reanchor = lambda camera: self.reanchor(camera, daemon.newest)
            taking = TakingOrders(open_things, socket, daemon, self._log, self._say)
            self._say(
                f"orders at {socket}: clearway go X,Y --robot NAME, stop, pause, resume, status"
            )
            page = self._serve_dashboard(daemon, open_things, socket, folder)
            self._hold_what_was_stopped(open_things, daemon, list(daemon.robots.values()), socket)
            missions = GiveMissions(daemon, self._say, for_orders=self.waits)
            self._notifier.send("READY=1")
            self._log.write("info", "ready", camera=seen_by.partition(" ")[2], port=ports)
            open_things.callback(self._notifier.send, "STOPPING=1")
            state, reason = self._drive_all(daemon, missions, taking, recorder)
            daemon.halt()
            if page is not None and self.interrupt.is_set():
                page.begin_closing()  # while the robots brake
            daemon.let_the_robots_stop()
            duration_s = world.clock() - daemon.started_s
            report = summarise_fleet(daemon, state, reason, duration_s)
            self._draw(folder, daemon, report)  # where simulated robots were is known until here
            self._log.write(
                "info", "finished", state=report.state, reason=reason, duration_s=duration_s
            )
        for doubt in world.doubts:
            self._say(f"trouble: {doubt}")
        self._write(folder, report)
        for remark in slowness(world.clock):
            self._say(remark)
        if recorder is not None:
            self._say(recorder.summary())
        return report, folder, self._exit_code_of(state, daemon)

    def _draw(self, folder: Path | None, daemon: Daemon, report: FleetReport) -> None:
        if folder is None:
            return
        try:
            write_picture(folder / "track.svg", daemon, report)
        except DrawError as error:
            self._say(f"trouble: {error}")

    def _write(self, folder: Path | None, report: FleetReport) -> None:
        if folder is None:
            return
        try:
            report.write(folder / "report.json")
        except UnwrittenFileError as error:
            self._say(f"trouble: {error}")

    def _refuse_what_is_no_port(self) -> None:
        """``PortError`` where waiting would not help, and with ``once`` where nobody waits."""
        for config in each_robot(self.config).values():
            if config.serial.port == SIMULATED:
                continue
            try:
                look_for_port(config.serial.port)
            except PortNotReadyError:
                if self._once:
                    raise

    def _open_journals(self, open_things: ExitStack) -> dict[str, Journal]:
        """A journal for each robot, beside each other."""
        journals = {}
        for name, config in each_robot(self.config).items():
            path = config.recording.journal
            if path is None:
                continue
            journal = open_things.enter_context(Journal(path, owner_of(config, self._file)))
            journals[name] = journal
            for sentence in filter(None, (journal.remark, journal.trouble)):
                self._log.write("warning", "trouble", reason=sentence)
                self._say(f"{name}: {sentence}")
        return journals

    def _drive_all(
        self,
        daemon: Daemon,
        missions: GiveMissions,
        taking: TakingOrders,
        recorder: Recorder | None,
    ) -> tuple[State, str]:
        limit_s, give_up_s = self._time_limit_s(), self.config.safety.give_up_s
        watchdog = Watchdog(self._notifier, self._watchdog_s, daemon.turns)
        attendance = Attendance(daemon, self._log, watchdog, recorder, self._say)
        lines = FleetLines(self._say, lambda told: self._notifier.send(f"STATUS={told}"))
        while True:
            missions.cycle()
            now = daemon.cycle()
            lines.cycle(now)
            taking.cycle()
            attendance.cycle(now.robots, troubles_of(now), time.monotonic())
            if self.interrupt.is_set():
                return State.STOPPED, self.why_interrupted(why_stopped(now))
            waits = daemon.stopping.waits_for_rearm
            has_met = waits or daemon.has_met_its_devices
            if self._once and now.time_s > give_up_s and not has_met:
                reason = f"given up after {give_up_s:g} s without all robots and the camera"
                return State.FAILED, f"{reason}: {now.sentence}"
            if now.time_s > limit_s:
                return State.FAILED, f"not done within {limit_s:g} s: {now.sentence}"
            if self._once and not waits and missions.are_given and now.is_over:
                return now.state, now.sentence

    def _exit_code_of(self, state: State, daemon: Daemon) -> int:
        interrupted = self.interrupt.is_set()
        if state is State.DONE or (interrupted and not self._once):
            return DONE
        if any(one.pilot.no_path for one in daemon.robots.values()):
            return NO_PATH
        return FAILED


def _of_nothing(config: Config, reason: str) -> FleetReport:
    """Of a run that was ended before it had robots and a camera."""
    return FleetReport("stopped", reason, 0.0, None, None, None, 0, {})
