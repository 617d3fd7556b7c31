"""A camera that hangs still for an hour, and one that is knocked: false alarms, delay, cost.

    python -m benchmarks.camera.drift [--frames 108000] [--knocks 10]

Writes benchmarks/results/camera_drift.md. Pictures are those of the simulated camera of
configs/simulation.yaml, 1280 x 960, with its noise of 2.5 grey levels, drawn anew for every frame
wherever a fixed point is looked for. What 2000 of them measure of each point is the noise of the
hour: each frame takes of each point a reading at random. A second hour has the same noise made so
large that the points' distances have half the limit as their mean. The cost is processor time of
the eye with and without the watch, by turns in one run. Everything random has a seed.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from navigation.config import Config, load_config
from navigation.config.simulation import SimulatedKnockSection
from navigation.loop.seeing.eye import Eye
from navigation.loop.seeing.eye_settings import eye_settings, marked_robots, place_settings
from navigation.simulator.arena import load_arena
from navigation.simulator.picture.camera import SimulatedCamera, make_camera
from navigation.simulator.picture.pinhole import pinhole_of
from navigation.simulator.settings import true_start_of
from planner.scene import FloatArray
from vision.camera.camera import Frame, Image
from vision.markers.markers import MarkerTracker, body_discs_px
from vision.watch.camera_place import CameraPlace
from vision.watch.drift import DriftTest, of_most
from vision.watch.fixed_points import HALF_PX, MARKER_HALF_PX, NEAR_PX, PointMeter

ROOT = Path(__file__).parents[2]
RESULT = ROOT / "benchmarks" / "results" / "camera_drift.md"
RATE_HZ = 30.0
SEED = 19
REACH_PX = max(HALF_PX, MARKER_HALF_PX) + NEAR_PX + 3
SIZES_PX = (2.5, 3.0, 20.0)
LOOKS = 150
MEASURED = 2000
HIGH_CAMERA = {"position_m": (1.155, 0.975, 2.9)}
MARKERS = [
    {"marker_id": 20 + i, "size_m": 0.08, "place_m": place, "heading_deg": 0.0}
    for i, place in enumerate([(-0.1, -0.1), (2.5, -0.1), (2.5, 1.9), (-0.1, 1.9), (1.2, 1.9)])
]


def configured(markers: bool) -> Config:
    """The example, with the camera high enough to see beside the arena."""
    values: dict[str, Any] = load_config(ROOT / "configs" / "simulation.yaml", {}).model_dump()
    values["simulation"]["camera"].update(HIGH_CAMERA)
    values["camera"]["calibration"] = None
    values["arena"]["floor_markers"] = MARKERS if markers else []
    return Config.model_validate(values)


def camera_of(config: Config, knock: SimulatedKnockSection | None = None) -> SimulatedCamera:
    """The simulated camera, where a knock has left it."""
    start = true_start_of(config)
    return make_camera(
        config,
        load_arena(config),
        [(config.robot, lambda _at_s: start)],
        time.monotonic,
        knock=knock,
    )


class Noisy:
    """A clean picture, and the same with fresh noise around places."""

    def __init__(self, places_px: NDArray[np.float64], rng: np.random.Generator) -> None:
        side = 2 * REACH_PX + 1
        corners = np.maximum(np.rint(places_px).astype(int) - REACH_PX, 0)
        self._parts = [np.s_[y : y + side, x : x + side] for x, y in corners.tolist()]
        # a bank of noise, of which each frame takes other parts: drawing is what costs time
        self._bank = np.rint(rng.normal(0.0, 2.5, (2048, 2048))).astype(np.int16)
        self._rng, self._side = rng, side

    def picture(self, clean: Image) -> Image:
        """With noise."""
        noisy = clean.copy()
        places = self._rng.integers(0, 2048 - self._side, (len(self._parts), 2)).tolist()
        for part, (x, y) in zip(self._parts, places, strict=True):
            rows, columns = clean[part].shape
            noise = self._bank[y : y + rows, x : x + columns]
            noisy[part] = np.clip(clean[part] + noise, 0, 255)
        return noisy


class Stage:
    """A configuration's arena without noise, and what its robot covers."""

    def __init__(self, config: Config) -> None:
        self.config, self.calibration = config, pinhole_of(config).calibration()
        self.clean = camera_of(config).render([true_start_of(config)], None)
        robots = marked_robots(config)
        tracker = MarkerTracker(self.calibration, robots, config.robot.dictionary)
        looks = (tracker.update(Frame(self.clean, i / RATE_HZ, i, "benchmark")) for i in range(9))
        (pose,) = next(found for found in looks if found)
        robot = config.robot
        self.discs = body_discs_px(pose, robot.radius_m, self.calibration, robot.marker_height_m)

    def knocked(self, knock: SimulatedKnockSection) -> Image:
        """The same from where a knock leaves the camera."""
        return camera_of(self.config, knock).render([true_start_of(self.config)], None)


class Watched:
    """A camera's place that is watched, from its first picture on."""

    def __init__(self, stage: Stage, seed: int) -> None:
        self._stage = stage
        self.place = CameraPlace(stage.calibration, place_settings(stage.config))
        rng = np.random.default_rng(seed)
        first = np.clip(stage.clean + rng.normal(0, 2.5, stage.clean.shape), 0, 255)
        self._now_s = 0.0
        self.place.look(first.astype(np.uint8), stage.discs, 0.0, may_learn=True)
        places = np.array([point.place_px for point in self.place.points])
        self._noisy = Noisy(places, rng)

    def see(self, clean: Image) -> bool:
        """One frame later: whether anything is said."""
        self._now_s += 1.0 / RATE_HZ
        picture = self._noisy.picture(clean)
        report = self.place.look(picture, self._stage.discs, self._now_s, may_learn=True)
        return bool(report.moved or report.lost or report.remarks)

    def readings(self, frames: int) -> FloatArray:
        """What is measured of each point (frames, n, 2) while nothing moves."""
        meter = PointMeter(self.place.points)
        pictures = (self._noisy.picture(self._stage.clean) for _ in range(frames))
        return np.stack([meter.measure(one, self._stage.discs).moved_px for one in pictures])


def an_hour(measured: FloatArray, limit_px: float, frames: int) -> tuple[int, float]:
    """False alarms of the camera and of single points, and the largest common distance."""
    rng = np.random.default_rng(SEED)
    count = measured.shape[1]
    test = DriftTest(1 + count, limit_px)
    alarms, largest_px, before = 0, 0.0, test.moved
    for i in range(frames):
        away = np.hypot(*measured[rng.integers(0, len(measured), count), np.arange(count)].T)
        most_px = of_most(away)
        test.update(np.concatenate([[most_px], away]), 1.0 / RATE_HZ, i / RATE_HZ)
        alarms += int(np.count_nonzero(test.moved & ~before))
        before, largest_px = test.moved, max(largest_px, most_px)
    return alarms, largest_px


def delays(stage: Stage, size_px: float, knocks: int) -> list[float]:
    """Seconds from a knock to the sentence, for knocks that tilt every way."""
    rng = np.random.default_rng(SEED + round(10 * size_px))
    found = []
    assert stage.config.simulation is not None
    focal_px = stage.config.simulation.camera.focal_px
    for number in range(knocks):
        towards = rng.uniform(0.0, 2.0 * np.pi)
        tilt = np.degrees(size_px / focal_px) * np.array([np.cos(towards), np.sin(towards)])
        knock = SimulatedKnockSection(from_s=0.0, tilt_deg=(float(tilt[0]), float(tilt[1])))
        other, watched = stage.knocked(knock), Watched(stage, number)
        if any(watched.see(stage.clean) for _ in range(45)):
            raise AssertionError("a false alarm before the knock")
        found.append(next((i for i in range(1, 151) if watched.see(other)), 10**6) / RATE_HZ)
    return found


def cost(config: Config) -> tuple[list[float], list[float], list[float], list[float]]:
    """Milliseconds to the robot's pose and to the end of a look: without the watch, with it."""
    eyes: list[Eye] = []
    calibration = pinhole_of(config).calibration()
    for watch in (False, True):
        tracker = MarkerTracker(calibration, marked_robots(config), config.robot.dictionary)
        place = CameraPlace(calibration, place_settings(config)) if watch else None
        eyes.append(Eye(calibration, tracker, eye_settings(config), place))
    camera, start = camera_of(config), true_start_of(config)
    rng = np.random.default_rng(SEED)
    pictures = [camera.render([start], rng) for _ in range(8)]
    times: list[list[float]] = [[], [], [], []]
    for i in range(LOOKS + 40):
        for turn, eye in enumerate(eyes if i % 2 else reversed(eyes)):
            which = turn if i % 2 else 1 - turn
            began, told = time.thread_time(), [0.0]
            frame = Frame(pictures[i % 8], i / RATE_HZ, i, "benchmark")
            eye.look(frame, _teller(told))
            ended = time.thread_time()
            if i >= 40 and i % 6 != 5:  # every sixth look searches the picture for doubles
                times[which].append(1e3 * (told[0] - began))
                times[2 + which].append(1e3 * (ended - began))
    return times[0], times[1], times[2], times[3]


def _teller(told: list[float]) -> Callable[[object], None]:
    def tell(_: object) -> None:
        told[0] = time.thread_time()

    return tell


def _rows(frames: int, knocks: int) -> Iterator[str]:
    for name, config in (("floor markers", configured(True)), ("corners", configured(False))):
        stage = Stage(config)
        measured = Watched(stage, SEED).readings(MEASURED)
        measured = measured[:, np.isfinite(measured).all(axis=(0, 2))]
        noise_px = float(measured.std(axis=0).max())
        limit_px = config.safety.camera_moved_px
        trembling = measured - measured.mean(axis=0)
        mean_px = float(np.hypot(*trembling.transpose(2, 0, 1)).mean(axis=0).max())
        large = 0.5 * limit_px / mean_px
        hours = (("its noise", 1.0, measured), ("large noise", large, large * trembling))
        for what, scale, readings in hours:
            alarms, largest_px = an_hour(readings, limit_px, frames)
            yield (
                f"| {name}: {frames} frames of {what} | {measured.shape[1]} points, "
                f"{scale * noise_px:.3f} px an axis | {alarms} false alarms | "
                f"largest common distance {largest_px:.2f} px |"
            )
        for size_px in SIZES_PX:
            seconds = delays(stage, size_px, knocks)
            yield (
                f"| {name}: knocked by {size_px:g} px | {knocks} knocks | "
                f"noticed after {statistics.median(seconds):.2f} s (median) | "
                f"{max(seconds):.2f} s (latest) |"
            )
        pose, pose_watched, look, look_watched = map(statistics.median, cost(config))
        yield (
            f"| {name}: a look | {LOOKS} pictures | {look:.2f} ms without the watch, "
            f"{look_watched:.2f} with it (+{look_watched - look:.2f}) | to the robot's pose "
            f"{pose:.2f} and {pose_watched:.2f} ms: x {pose_watched / pose:.2f} |"
        )


def main() -> None:
    """Measure and write the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--frames", type=int, default=108_000)
    parser.add_argument("--knocks", type=int, default=10)
    asked = parser.parse_args()
    lines = [
        "# A camera that is knocked",
        "",
        "`python -m benchmarks.camera.drift`; 1280 x 960 pixels at 30 a second, noise of 2.5 grey",
        "levels, the robot in the picture; `safety.camera_moved_px` is 2.",
        "",
        "| | | | |",
        "|---|---|---|---|",
    ]
    for row in _rows(asked.frames, asked.knocks):
        print(row, flush=True)
        lines.append(row)
    RESULT.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
