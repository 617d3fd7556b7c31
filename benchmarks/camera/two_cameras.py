"""Two cameras over one arena against one camera: outlines, poses, and the time to a pose.

    python -m benchmarks.camera.two_cameras

Writes benchmarks/results/two_cameras.md. All three cameras are the simulator's, equally high and
with one lens, so that a pixel is as large on the floor: the single one is that of
configs/simulation.yaml, the two those of configs/two_cameras.yaml. Truth is the simulator's; the
calibrations are the cameras' true ones. Times are of one run by turns.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from navigation.config import Config, load_config
from navigation.config.several.each_camera import each_camera
from navigation.loop.seeing.eye import Eye
from navigation.loop.seeing.eye_settings import eye_settings, marked_robots
from navigation.loop.seeing.joined.joined_eye import JoinedEye
from navigation.loop.seeing.joined.joined_parts import joined_eye
from navigation.run.calibrations import floor_plan_of
from navigation.simulator.arena import load_arena
from navigation.simulator.picture.camera import SimulatedCamera, make_camera
from navigation.simulator.picture.pinhole import pinhole_of
from planner.scene import Arc, Scene, record_edges
from vision.camera.camera import Frame
from vision.markers.markers import MarkerTracker, RobotPose

ROOT = Path(__file__).parents[2]
RESULT = ROOT / "benchmarks" / "results" / "two_cameras.md"
RATE_HZ = 30.0
SPEED_M_S = 0.3
SECONDS = 12.0
WAYS = ((0.25, 0.25, 0.0), (0.3, 0.95, 0.0), (0.25, 1.62, 0.0), (2.2, 0.25, math.pi))
"""Each begins here with this heading and crosses the seam at a constant speed."""
LENGTH_M = 1.9

Points = NDArray[np.float64]


@dataclass
class Poses:
    """What an eye told along the ways: errors in millimetres and degrees, and how long it took."""

    off_mm: list[float] = field(default_factory=list)
    off_deg: list[float] = field(default_factory=list)
    took_ms: list[float] = field(default_factory=list)
    whole_ms: list[float] = field(default_factory=list)


def configs() -> tuple[Config, Config]:
    """That of one camera, and that of two, both with the cameras' true calibrations."""
    one = load_config(ROOT / "configs" / "simulation.yaml", {})
    camera = one.camera.model_copy(update={"calibration": None})
    return (
        one.model_copy(update={"camera": camera}),
        load_config(ROOT / "configs" / "two_cameras.yaml", {}),
    )


class Filmed:
    """One simulated camera, and the eye that its frames go to."""

    def __init__(self, config: Config, eye: Eye | JoinedEye, name: str, delay_s: float) -> None:
        arena = load_arena(config)
        place = (0.2, 0.2, 0.0)
        self.camera: SimulatedCamera = make_camera(
            config,
            arena,
            [(config.robot, lambda _at_s: place)],
            clock=lambda: 0.0,
            wait=lambda _: None,
        )
        self.eye, self.name, self.delay_s = eye, name, delay_s
        assert config.simulation is not None
        self.rng = np.random.default_rng(config.simulation.seed)
        self.number = 0

    def look(self, pose: tuple[float, float, float], time_s: float, found: Poses) -> None:
        """Film the robot at a pose; what the eye tells of it, against the truth."""
        frame = Frame(self.camera.render([pose], self.rng), time_s, self.number, self.name)
        self.number += 1
        told: list[tuple[float, RobotPose]] = []
        began_s = time.process_time()

        def tell(poses: Mapping[int, RobotPose]) -> None:
            told.extend((time.process_time(), one) for one in poses.values())

        self.eye.look(frame, tell)
        found.whole_ms.append(1000.0 * (time.process_time() - began_s))
        for at_s, one in told:
            found.off_mm.append(1000.0 * math.dist((one.x, one.y), pose[:2]))
            turned = math.remainder(one.heading_rad - pose[2], math.tau)
            found.off_deg.append(abs(math.degrees(turned)))
            found.took_ms.append(1000.0 * (at_s - began_s))


def poses() -> tuple[Poses, Poses]:
    """Of one camera and of two along the same ways, frame by frame by turns."""
    one, two = configs()
    plan = floor_plan_of(two)
    assert plan is not None
    alone, both = Poses(), Poses()
    for x, y, heading in WAYS:
        calibration = pinhole_of(one).calibration()
        tracker = MarkerTracker(calibration, marked_robots(one), one.robot.dictionary)
        joined = joined_eye(two, plan)
        films = [(Filmed(one, Eye(calibration, tracker, eye_settings(one)), "", 0.0), alone)]
        films += [
            (Filmed(config, joined, name, i * 0.5 / RATE_HZ), both)
            for i, (name, config) in enumerate(each_camera(two).items())
        ]
        for number in range(int(LENGTH_M / SPEED_M_S * RATE_HZ)):
            for film, found in films:
                time_s = number / RATE_HZ + film.delay_s
                way_m = SPEED_M_S * time_s
                pose = (x + way_m * math.cos(heading), y + way_m * math.sin(heading), heading)
                film.look(pose, time_s, found)
    return alone, both


def outlines() -> tuple[list[float], list[float]]:
    """How far the borders found lie from the true ones, in pixels, of one camera and of two."""
    one, two = configs()
    plan = floor_plan_of(two)
    assert plan is not None
    calibration = pinhole_of(one).calibration()
    truth = _border(load_arena(one).scene)
    tracker = MarkerTracker(calibration, marked_robots(one), one.robot.dictionary)
    eyes: list[tuple[Eye | JoinedEye, dict[str, Config], float]] = [
        (
            Eye(calibration, tracker, eye_settings(one)),
            {"": one},
            calibration.metres_per_pixel,
        ),
        (joined_eye(two, plan), each_camera(two), plan.calibration.metres_per_pixel),
    ]
    off = []
    for eye, cameras, pixel_m in eyes:
        films = [Filmed(config, eye, name, 0.0) for name, config in cameras.items()]
        scene = None
        for number in range(6):
            for film in films:
                picture = film.camera.render([(0.2, 0.2, 0.0)], film.rng)
                frame = Frame(picture, number / RATE_HZ, number, film.name)
                scene = eye.look(frame).scene or scene
        assert scene is not None
        assert len(scene.objects) == len(load_arena(one).scene.objects)
        off.append((_off_m(_border(scene), truth) / pixel_m).tolist())
    return off[0], off[1]


def _border(scene: Scene) -> Points:
    """Points every millimetre or so along all borders."""
    parts = []
    for thing in scene.objects:
        for record in thing.records:
            for edge in record_edges(record):
                share = np.linspace(0.0, 1.0, 400)[:, None]
                if isinstance(edge, Arc):
                    begin, sweep = edge.sweep(y_down=False)
                    angles = begin + sweep * share
                    ring = np.hstack([np.cos(angles), np.sin(angles)])
                    parts.append(np.array(edge.center) + edge.radius * ring)
                else:
                    a, b = np.array(edge.start), np.array(edge.end)
                    parts.append(a + (b - a) * share)
    return np.concatenate(parts)


def _off_m(points: Points, truth: Points) -> Points:
    """The distance of points from the truth's nearest piece between two of its points."""
    off = []
    for point in points:
        away = np.hypot(*(truth - point).T)
        near = int(away.argmin())
        best = float(away[near])
        for other in (near - 1, near + 1):
            if 0 <= other < len(truth):
                a, along = truth[near], truth[other] - truth[near]
                length2 = float(along @ along)
                if 0.0 < length2 < 1e-3:
                    share = min(max(float((point - a) @ along) / length2, 0.0), 1.0)
                    best = min(best, float(np.hypot(*(a + share * along - point))))
        off.append(best)
    return np.array(off)


def _rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _row(name: str, found: Poses) -> str:
    off, deg = found.off_mm, found.off_deg
    return (
        f"| {name} | {_rms(off):.3f} | {np.percentile(off, 99):.3f} | {_rms(deg):.3f} "
        f"| {np.median(found.took_ms):.2f} | {np.percentile(found.took_ms, 99):.2f} "
        f"| {np.median(found.whole_ms):.2f} | {len(off)} |"
    )


def main() -> None:
    """Measure all, and write the page."""
    alone, both = poses()
    one, two = outlines()
    lines = [
        "# Two cameras over one arena",
        "",
        "Made by `python -m benchmarks.camera.two_cameras`.",
        "",
        "Borders found against the true ones of `configs/arenas/laboratory.txt`, in px of 2 mm.",
        "Target: within 1 px, also on the seam.",
        "",
        "| cameras | rms px | farthest px |",
        "|---|---|---|",
        f"| one | {_rms(one):.3f} | {max(one):.3f} |",
        f"| two | {_rms(two):.3f} | {max(two):.3f} |",
        "",
        f"Poses of a robot that drives {SPEED_M_S:g} m/s across the seam, {len(WAYS)} times; the",
        "two cameras' pictures are half a period apart. Milliseconds of processor time from the",
        "picture to the pose that is sent, and for everything. Target: rms within 1.1 x.",
        "",
        "| cameras | rms mm | p99 mm | rms deg | pose ms | p99 ms | all ms | poses |",
        "|---|---|---|---|---|---|---|---|",
        _row("one", alone),
        _row("two", both),
        "",
        f"Poses: {_rms(both.off_mm) / _rms(alone.off_mm):.2f} x the error of one camera, headings "
        f"{_rms(both.off_deg) / _rms(alone.off_deg):.2f} x, the time to a pose "
        f"{np.median(both.took_ms) / np.median(alone.took_ms):.2f} x.",
    ]
    RESULT.write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
