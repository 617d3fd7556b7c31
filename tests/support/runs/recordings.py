"""Recordings made in virtual time: the simulated camera, the eye and the planner, no daemon.

The robot stands at its start; frames come at 30 a second of a clock that waits for nobody but
the recorder.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from navigation.config import Config, load_config
from navigation.loop.daemon import Daemon
from navigation.loop.planning import ArenaPlanner
from navigation.loop.recorder import Recorder
from navigation.loop.run_state import RunState
from navigation.loop.seeing.eye import Eye
from navigation.loop.seeing.eye_settings import eye_settings, marked_robots
from navigation.loop.stages import plan_settings
from navigation.mission.cycle import PlanRequest
from navigation.mission.mission import Station
from navigation.recording.events import PlanAnswered, PlanAsked, RoadmapBuilt, SceneSeen
from navigation.run.calibrations import shown_calibration
from navigation.run.virtual_run import run_virtually
from navigation.simulator.arena import load_arena
from navigation.simulator.picture.camera import make_camera
from navigation.simulator.settings import true_start_of
from tests.support.runs.light_camera import in_small_pictures
from tests.support.waiting import wait_until
from vision.markers.markers import MarkerTracker

CONFIGS = Path(__file__).parents[3] / "configs"
BEGAN = datetime(2026, 3, 4, 5, 6, 7)
GOAL = (0.20, 1.40, 1.5)
EVERY = {"picture_rate_hz": 60.0, "picture_format": "png"}
"""Every picture, without loss."""


def recording_config(**recording: Any) -> Config:
    """The simulated run with settings of its recording."""
    config = load_config(CONFIGS / "simulation.yaml", {})
    changed = config.recording.model_copy(update=recording)
    return config.model_copy(update={"recording": changed})


class RecordedBench:
    """Camera, eye and planner of a configuration, with a recorder that hears of all."""

    def __init__(self, config: Config, folder: Path, file: str | None = None) -> None:
        self.config, self.now_s = config, 1000.0
        calibration = shown_calibration(config, None)
        self.arena = load_arena(config)
        self.start = true_start_of(config)
        driven = [(config.robot, lambda _at_s: self.start)]
        self.camera = make_camera(config, self.arena, driven, self.clock, self.wait)
        tracker = MarkerTracker(calibration, marked_robots(config), config.robot.dictionary)
        self.eye = Eye(calibration, tracker, eye_settings(config))
        self.planner = ArenaPlanner(plan_settings(config))
        self.recorder = Recorder(
            config, calibration, folder, file=file, clock=self.clock, began=BEGAN
        )
        self.revision = 0
        self.camera.open()

    def clock(self) -> float:
        return self.now_s

    def wait(self, seconds: float) -> None:
        self.now_s += seconds

    def is_written(self) -> bool:
        counts = self.recorder.counts()
        return bool(counts.failed) or counts.waiting == 0

    def frames(self, count: int, *, patient: bool = True) -> None:
        """See so many frames; ``patient``: each is written before the next comes."""
        for _ in range(count):
            self.frame()
            if patient:
                assert wait_until(self.is_written)

    def frame(self) -> None:
        """See one frame, and make the roadmap where the scene is new."""
        frame = self.camera.read(1.0)
        assert frame is not None
        glimpse = self.eye.look(frame)
        seen = None
        if glimpse.scene is not None:
            self.revision += 1
            seen = SceneSeen(frame.captured_s, self.revision, glimpse.scene)
            self.planner.see(glimpse.scene, self.revision)
        self.recorder.saw(frame, glimpse.poses, seen)
        if seen is not None:
            assert self.planner.roadmap is not None
            self.recorder.put(RoadmapBuilt(self.now_s, self.revision, self.planner.roadmap))

    def plan(self, number: int = 1, goal: tuple[float, float, float] = GOAL) -> None:
        """Ask for a way from the start to ``goal``, and answer."""
        station = Station(*goal)
        request = PlanRequest(number, self.start, (station,), self.revision)
        self.recorder.put(PlanAsked(self.now_s, request))
        self.recorder.put(PlanAnswered(self.now_s, self.planner.answer(request)))


def make_recording(
    folder: Path, each: Callable[[RecordedBench], None], **recording: Any
) -> list[Path]:
    """The files of a recording, of small pictures, of what ``each`` does with the bench."""
    bench = RecordedBench(in_small_pictures(recording_config(**recording)), folder)
    with bench.recorder:
        each(bench)
    return sorted(folder.glob("*.mcap"))


@cache
def small_recording() -> bytes:
    """A file of three pictures of small size, a scene and a plan."""

    def each(bench: RecordedBench) -> None:
        bench.frames(2)
        bench.plan()
        bench.frames(1)

    with TemporaryDirectory() as folder:
        (file,) = make_recording(Path(folder), each, picture_quality=20)
        return file.read_bytes()


def record_alcove(
    folder: Path, until: Callable[[Daemon, RunState], bool], **recording: Any
) -> list[Path]:
    """The files of a recording of two robots in a corridor with one niche, ``until`` says so."""
    config = in_small_pictures(load_config(CONFIGS / "alcove.yaml", {}))
    changed = config.recording.model_copy(update=recording)

    def look(daemon: Daemon, now: RunState) -> bool:
        # virtual time does not wait for the writer, which leaves out pictures where it is behind
        recorder = daemon._recorder
        assert recorder is not None
        assert wait_until(lambda: not recorder.counts().waiting or bool(recorder.counts().failed))
        return until(daemon, now)

    run_virtually(config.model_copy(update={"recording": changed}), look=look, record=folder)
    return sorted(folder.glob("*.mcap"))
