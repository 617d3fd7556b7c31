"""One run: robot, line, camera and program, driven to the moment of the attack, and its end.

Seconds are monotonic; metres.
"""

from __future__ import annotations

import contextlib
import json
import math
import signal
import socket
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.adversary.bars import (
    Moment,
    Outcome,
    blind_m,
    drove_without_permit_s,
    judge,
    least_gap_m,
    said_to_drive_s,
    stood_after_s,
)
from benchmarks.adversary.processes import Process, ProcessError, clearway, module
from benchmarks.adversary.scene import Errand, read_config, write_config, write_driver_config
from benchmarks.adversary.stage.line import Line
from benchmarks.adversary.truth import TruthWatch
from navigation.config.known_robots import CLEARWAY
from navigation.control import ControlError, send_order
from navigation.simulator.arena import load_arena
from planner.scene import FloatArray
from tests.support.waiting import wait_until

UP_WITHIN_S = 60.0
DRIVES_WITHIN_S = 30.0
MAY_DRIVE_WITHIN_S = 6.0
AFTER_STOP_S = 1.6
HAND_S = 0.05
"""A hand's order takes so long at most to reach the robot."""
STANDS_M, STANDS_LONG_S = 0.001, 3.5
"""A robot that stays within so much for so long is not expected to drive any more."""
OVER = ("done", "failed", "stopped")


@dataclass(frozen=True, slots=True)
class Needs:
    """What an attack needs besides robot, line and program.

    ``http_camera``: a network camera in place of the simulated one in the program; ``handled``:
    a robot that can be carried; ``page``: the page; ``recorded``: the run is recorded;
    ``stdout``: where the program's output goes; ``driver``: a robot behind a maker's driver.
    """

    http_camera: bool = False
    handled: bool = False
    page: bool = False
    recorded: bool = False
    stdout: Path | None = None
    driver: str | None = None


class Rig:
    """A context manager; afterwards no process of it is left."""

    def __init__(self, folder: Path, errand: Errand, needs: Needs, seed: int) -> None:
        self.folder, self.errand, self.needs, self.seed = folder, errand, needs, seed
        self.rng = np.random.default_rng(seed)
        self.socket = folder / "door" / "c.sock"
        self.page_port = _free_port() if needs.page else None
        self.camera_port = _free_port()
        self.halted_s: list[tuple[float, float]] = []
        """From when to when the robot's own process was stopped."""
        self.said: list[tuple[float, str]] = []
        """Each state of the mission that was asked for, and when; empty: no answer."""
        self.stop_s: float | None = None
        self.stop_ordered_s: float | None = None
        self.end: tuple[str, str] | None = None
        """State and sentence, where the attack has asked for them at a better moment."""
        self._things = ExitStack()
        self.daemons: list[Process] = []

    def __enter__(self) -> Rig:
        try:
            self._start()
        except BaseException:
            self._things.close()
            raise
        return self

    def __exit__(self, *_exc: object) -> None:
        self._things.close()

    def process(self, process: Process) -> Process:
        """One more process, ended with the run."""
        self._things.callback(process.end)
        return process

    def _start(self) -> None:
        """Everything but the program, which takes longest: it need not wait for them."""
        self.config_file = self._write_config()
        self.config = read_config(self.config_file)
        poses = self.folder / "robot.pose"
        poses.touch()
        x_m, y_m, heading_deg = self.errand.start
        words: list[str | Path] = ["--poses", poses, "--start"]
        words += [f"{x_m},{y_m},{heading_deg}", "--seed", str(self.seed)]
        words += ["--kind", self.needs.driver or CLEARWAY]
        handled = self.needs.handled
        arguments = module("handled_robot", *words) if handled else clearway("robot", *words)
        self.robot = self.process(Process("robot", arguments, self.folder))
        self.camera: Process | None = None
        if self.needs.http_camera:
            self.start_camera()
        line = Line(self.folder / "port", np.random.default_rng(self.seed))
        self.line = self._things.enter_context(line)
        arena = load_arena(self.config)
        watch = TruthWatch(poses, arena, self.config.robot.radius_m)
        self.truth = self._things.enter_context(watch)

    def _write_config(self) -> Path:
        if self.needs.driver is not None:
            return write_driver_config(self.folder, self.needs.driver)
        address = f"http://127.0.0.1:{self.camera_port}/stream.mjpg"
        source = address if self.needs.http_camera else "simulated"
        return write_config(self.folder, self.errand, source, self.page_port)

    # The processes.

    def start_camera(self) -> None:
        """The network camera, the first time or again."""
        words: list[str | Path] = [self.config_file, "--port", str(self.camera_port)]
        words += ["--seed", str(self.seed)]
        self.camera = self.process(Process("camera", module("camera_server", *words), self.folder))

    def show(self, **faults: Any) -> None:
        """Faults of the network camera; none: a good one."""
        assert self.camera is not None
        self.camera.say(json.dumps(faults))

    @property
    def daemon(self) -> Process:
        return self.daemons[-1]

    def start_daemon(self) -> None:
        """`clearway run`, the first time or again."""
        words: list[str | Path] = ["run", self.config_file, "--socket", self.socket]
        if not self.needs.page:
            words.append("--no-dashboard")
        if self.needs.recorded:
            words += ["--record", self.folder / "recordings"]
        process = Process("daemon", clearway(*words), self.folder, self.needs.stdout)
        self.daemons.append(self.process(process))

    def start_another(self, config: Path) -> None:
        """A second program beside the first."""
        words: list[str | Path] = [
            "run",
            config,
            "--no-dashboard",
            "--socket",
            self.folder / "d.sock",
        ]
        self.process(Process("second", clearway(*words), self.folder))

    def wait_for_answer(self) -> None:
        """Until robot and program are there, and it takes orders."""
        if not self.line.is_attached:
            self.line.attach(self.robot.first_line(UP_WITHIN_S))
        up = wait_until(lambda: self.status() is not None or not self.daemon.runs, UP_WITHIN_S)
        if not up or not self.daemon.runs:
            raise ProcessError(f"the program did not come up: {self.daemon.last_words()}")

    def drive(self, metres: float, may_stand: bool = False) -> None:
        """Until the robot is so far from its start; ``may_stand``: or has not come so far."""
        self.wait_for_answer()
        far = wait_until(
            lambda: self.truth.travelled_m() >= metres or not self.daemon.runs,
            MAY_DRIVE_WITHIN_S if may_stand else DRIVES_WITHIN_S,
        )
        if not (far or may_stand) or not self.daemon.runs:
            raise ProcessError(f"the robot did not drive {metres:.2f} m: {self.status()}")

    # What an attack does.

    def order(self, **request: object) -> dict[str, Any] | None:
        """An order to the program and its answer; None where there is none."""
        with contextlib.suppress(ControlError):
            return send_order(self.socket, request)
        return None

    def status(self) -> dict[str, Any] | None:
        status = self.order(order="status") if self.socket.exists() else None
        self.said.append((time.monotonic(), status["state"] if status else ""))
        return status

    def watch(self, seconds: float) -> bool:
        """Look on for so long, or until a contact; whether there was none."""
        return not self.truth.touched.wait(seconds)

    def watch_mission(self, seconds: float, however_long: bool = False) -> None:
        """Look on for so long, or until a contact, the mission's end, or a long stand.

        ``however_long``: not until a stand.
        """
        end_s = time.monotonic() + seconds
        place, since_s = self.truth.pose, time.monotonic()
        while (now_s := time.monotonic()) < end_s and self.watch(0.5):
            status = self.status()
            if status is not None and status["state"] in OVER:
                return
            before, place = place, self.truth.pose
            if before is None or place is None or math.dist(before, place) > STANDS_M:
                since_s = now_s
            elif now_s - since_s > STANDS_LONG_S and not however_long:
                return

    def note_end(self) -> None:
        """Keep what the program says of itself now."""
        status = self.status()
        if status is not None:
            self.end = status["state"], status["reason"]
        elif not self.daemon.runs:
            self.end = "", f"the program ended: {self.daemon.last_words()}"

    def stop(self) -> None:
        """Order a stop and take the time of its answer; only the first counts."""
        if self.stop_ordered_s is not None:
            return
        self.stop_ordered_s = time.monotonic()
        answer = self.order(order="stop", reason="the judge orders a stop")
        if answer is not None:
            self.stop_s = time.monotonic() - self.stop_ordered_s
            self.said.append((time.monotonic(), answer["state"]))

    def freeze(
        self, process: Process, seconds: float, meanwhile: Callable[[], object] | None = None
    ) -> None:
        """SIGSTOP for so long."""
        began_s = time.monotonic()
        process.signal(signal.SIGSTOP)
        if meanwhile is not None:
            meanwhile()
        self.watch(began_s + seconds - time.monotonic())
        process.signal(signal.SIGCONT)
        if process is self.robot:
            self.halted_s.append((began_s, time.monotonic()))

    def carry(self, there: tuple[float, float, float], seconds: float) -> None:
        """A hand lifts the robot and puts it down there."""
        began_s = time.monotonic()
        self.truth.by_hand.append((began_s, began_s + seconds + HAND_S))
        self.robot.say(json.dumps({"carry": there, "seconds": seconds}))
        self.watch(seconds + HAND_S)

    def grip(self, share: float) -> None:
        """How much of the wheels' travel the floor takes from now on."""
        self.robot.say(json.dumps({"grip": share}))

    def power(self, motors: bool) -> None:
        """Switch the power of the robot's motors on or off."""
        self.robot.say(json.dumps({"motors": motors}))

    # The judgement.

    def judged(self, outcome: Outcome) -> Outcome:
        """Stop, look on while the robot comes to rest, and measure."""
        if self.end is None:
            self.note_end()
        self.stop()
        time.sleep(AFTER_STOP_S)  # whatever moves now is to be seen
        rows = self.truth.rows()
        np.savez(self.folder / "truth.npz", rows=rows, permits_s=self.line.permits_s())
        assert self.stop_ordered_s is not None
        outcome.stop_s = self.stop_s
        outcome.state, outcome.sentence = self.end or ("", "no answer")
        by_hand = self.truth.by_hand
        outcome.least_gap_m = least_gap_m(rows, self.truth.arena, self.truth.radius_m, by_hand)
        outcome.said_s = said_to_drive_s(rows, self.said)
        outcome.stood_s = stood_after_s(rows, self.stop_ordered_s)
        if not by_hand:  # a hand's way is not the program's
            outcome.blind_m = blind_m(rows, self.line.fixes)
        self.judge(outcome, rows)
        return outcome

    def judge(self, outcome: Outcome, rows: FloatArray) -> None:
        """Every bar, and those of this rig's robot alone."""
        moment = Moment(self.line.permits_s(), self.truth.by_hand, self.halted_s)
        outcome.drove_s = drove_without_permit_s(rows, moment)
        judge(outcome)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
