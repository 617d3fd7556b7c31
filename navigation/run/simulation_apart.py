"""The simulation in a process of its own, which takes no time from the daemon.

In one process its threads would share the interpreter with the control loop and make it late. Only
what a cable would carry passes: port names, pictures and, for the report, the truth.

Each pipe answers one question at a time; every camera has its own. The process ends with this one.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping, MutableSequence
from multiprocessing.connection import Connection
from typing import Any, Final

import numpy as np

from navigation.config import Config
from navigation.machine.child import FRESH, start_child
from navigation.run.devices.world_clock import world_clock
from navigation.run.simulation import Simulation, cameras_of
from navigation.simulator.slowing_clock import SHARED_VALUES
from planner.scene import FloatArray
from vision.camera.camera import Camera, CameraError, Frame, Image, SourceState

ENDED: Final = "the simulation's process has ended"
END_S: Final = 2.0
"""For the process to end by itself."""


class SimulationEndedError(RuntimeError):
    """The simulation's process has ended."""


class _Asked:
    """One end of a pipe: returns a method's result or raises its exception."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self._lock = threading.Lock()

    def __call__(self, name: str, *arguments: object) -> Any:
        with self._lock:
            try:
                self._pipe.send((name, arguments))
                answer, error = self._pipe.recv()
            except (EOFError, OSError):
                raise SimulationEndedError(ENDED) from None
        if error is not None:
            raise error
        return answer


class SimulationApart:
    """`Simulation` in another process, with the same methods. ``clock`` is this process's."""

    def __init__(self, config: Config) -> None:
        shared = FRESH.RawArray("d", SHARED_VALUES)
        self.clock = world_clock(config, shared)
        ours, theirs = FRESH.Pipe()
        pictures = {name: FRESH.Pipe() for name in cameras_of(config)}
        sides = {name: side for name, (_, side) in pictures.items()}
        self.process = start_child(_simulate, theirs, sides, shared, config)
        for side in (theirs, *sides.values()):
            side.close()
        self._ask = _Asked(ours)
        self._cameras = {name: _Asked(side) for name, (side, _) in pictures.items()}
        self.ports: dict[str, str] = self._ask("ports")

    def track(self, name: str) -> FloatArray:
        """Track of the robot (n, 4); empty once the process has ended."""
        try:
            track: FloatArray = self._ask("track", name)
        except SimulationEndedError:
            return np.empty((0, 4))
        return track

    def pose(self, name: str) -> tuple[float, float, float]:
        """Present pose of the robot; ``SimulationEndedError`` if it is unknown."""
        pose: tuple[float, float, float] = self._ask("pose", name)
        return pose

    def open_camera(self, name: str | None = None) -> Camera:
        """Make a closed camera."""
        return CameraApart(self._cameras[name])

    def start(self) -> None:
        """Switch the robots on."""
        self._ask("start")

    def stop(self) -> None:
        """Switch the robots off and end the process."""
        try:
            self._ask("stop")
        except SimulationEndedError:
            return
        self.process.join(END_S)
        self.process.kill()


class CameraApart:
    """The simulated camera as a `vision.camera.camera.Camera` of this process."""

    def __init__(self, ask: _Asked) -> None:
        self._ask = ask
        self.name, self.may_repeat = self._asked("make")
        self.state: SourceState = "closed"
        self.reason = ""
        self.rate_hz = 0.0

    def open(self) -> None:
        """Start giving frames."""
        self._asked("open")
        self.state = "running"

    def read(self, timeout_s: float) -> Frame | None:
        """Return the next frame; None if none came in time."""
        seen, self.rate_hz = self._asked("read", timeout_s)
        if seen is None:
            return None
        image, captured_s, sequence = seen
        return Frame(image, captured_s, sequence, self.name)

    def close(self) -> None:
        """Stop; harmless if closed."""
        if self.state == "running":
            self.state = "closed"
            try:
                self._ask("close")
            except SimulationEndedError:
                return

    def _asked(self, name: str, *arguments: object) -> Any:
        try:
            return self._ask(name, *arguments)
        except SimulationEndedError as error:
            raise CameraError(f"simulated camera: {error}") from None


def _simulate(
    pipe: Connection,
    pictures: Mapping[str | None, Connection],
    shared: MutableSequence[float],
    config: Config,
) -> None:
    simulation = Simulation(config, world_clock(config, shared, side=1))
    for name, side in pictures.items():
        camera = _CameraHere(simulation, name)
        threading.Thread(target=_answer, args=(side, camera), name="camera", daemon=True).start()
    _answer(pipe, simulation, last="stop")


class _CameraHere:
    def __init__(self, simulation: Simulation, name: str | None) -> None:
        self._simulation, self._name = simulation, name
        self._camera: Camera | None = None

    def make(self) -> tuple[str, bool]:
        """Name, and True if its pictures may repeat."""
        self.close()
        self._camera = self._simulation.open_camera(self._name)
        return self._camera.name, self._camera.may_repeat

    def open(self) -> None:
        assert self._camera is not None
        self._camera.open()

    def read(self, timeout_s: float) -> tuple[tuple[Image, float, int] | None, float]:
        """Picture, time and number of a frame, and the rate."""
        assert self._camera is not None
        frame = self._camera.read(timeout_s)
        seen = None if frame is None else (frame.image, frame.captured_s, frame.sequence)
        return seen, self._camera.rate_hz

    def close(self) -> None:
        if self._camera is not None:
            self._camera.close()


def _answer(pipe: Connection, side: object, last: str = "") -> None:
    while True:
        try:
            name, arguments = pipe.recv()
        except EOFError:
            return
        try:
            member = getattr(side, name)
            answer = member(*arguments) if callable(member) else member
            pipe.send((answer, None))
        except Exception as error:  # noqa: BLE001 - it belongs to who asked
            pipe.send((None, error))
        if name == last:
            return
