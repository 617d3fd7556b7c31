"""Compile every kernel before the robot may move: a first compilation takes a minute or two.

A small arena goes through the whole chain once: a marker and an obstacle are seen, a way past
the obstacle is planned and timed. Loaded from the kernel cache this takes about a second. The
first time on a machine the planner's kernels are compiled in a second process beside the eye's,
and what is going on is said.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

import planner
from navigation.config import Config
from navigation.eye import Body, Eye, EyeSettings
from planner.path import Path as PlannedPath
from planner.scene import (
    Arc,
    Bounds,
    CircleRecord,
    PolygonRecord,
    Scene,
    SceneObject,
    Segment,
)
from planner.smooth import smooth_path
from planner.trajectory import default_limits
from vision.calibration import Calibration
from vision.camera import Frame
from vision.markers import MarkedRobot, MarkerTracker, dictionary_by_name

SIZE_PX = (400, 300)
METRES_PER_PIXEL = 0.005
MARKER_PX = 40
RADIUS_M = 0.15
BODY_RADIUS_M = 0.22
"""Holds the marker with its quiet zone."""
BOUNDS = Bounds(0.0, 0.0, 2.0, 1.5)


def warm_up(config: Config, say: Callable[[str], None]) -> None:
    """Run eye, roadmap, plan, smoothing and timing once; ``say`` gets a line of news at a time."""
    if not kernels_are_cold():
        _run_planner(_see(config))
        return
    say("compiling the kernels, once on this machine: a minute or two")
    begin_s = time.monotonic()
    code = "from navigation.warm_up import compile_planner; compile_planner()"
    beside = subprocess.Popen([sys.executable, "-c", code])
    try:
        scene = _see(config)
        say(f"  eye compiled after {time.monotonic() - begin_s:.0f} s")
        beside.wait()
    finally:
        beside.kill()
        beside.wait()
    # loads what the other process has compiled, and compiles what it could not
    _run_planner(scene)
    say(f"  planner compiled after {time.monotonic() - begin_s:.0f} s")


def compile_planner() -> None:
    """Send a scene with every kind of primitive through the planner, for its kernels."""
    ring = (
        Segment((1.2, 0.4), (1.5, 0.4)),
        Arc((1.5, 0.4), (1.5, 0.7), (1.5, 0.55), 0.15, ccw=True),
        Segment((1.5, 0.7), (1.2, 0.7)),
        Segment((1.2, 0.7), (1.2, 0.4)),
    )
    objects = (
        SceneObject(0, (CircleRecord((0.8, 0.9), 0.12),)),
        SceneObject(1, (PolygonRecord(ring),)),
    )
    _run_planner(Scene("m", BOUNDS, objects))


def kernels_are_cold() -> bool:
    """Whether no compiled kernels lie where numba will look for them."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    beside_the_source = Path(planner.__file__).parent / "__pycache__"
    folder = Path(chosen) if chosen else beside_the_source
    return next(folder.rglob("insertion_kernels.*.nbi"), None) is None


def _see(config: Config) -> Scene:
    calibration = Calibration.from_scale(METRES_PER_PIXEL, SIZE_PX)
    robot = MarkedRobot(config.robot.marker_id, MARKER_PX * METRES_PER_PIXEL)
    eye = Eye(
        calibration,
        MarkerTracker(calibration, [robot], config.robot.dictionary),
        EyeSettings(
            bounds_m=BOUNDS,
            polarity=config.vision.polarity,
            method=config.vision.method,
            threshold=config.vision.threshold,
            driven_id=robot.id,
            bodies={robot.id: Body(BODY_RADIUS_M, 0.0)},
        ),
    )
    picture = _picture(config)
    scene = Scene("m", BOUNDS, ())
    for number in range(8):
        glimpse = eye.look(Frame(picture[number % 2], number / 30.0, number, "warm-up"))
        scene = glimpse.scene or scene
    return scene


def _run_planner(scene: Scene) -> None:
    roadmap = planner.build_roadmap(scene, RADIUS_M)
    for prefer in (0.0, 0.5, 1.0):
        path = roadmap.plan((0.3, 0.3), (1.7, 1.2), prefer=prefer)
        if isinstance(path, PlannedPath):
            path = smooth_path(path, roadmap.path_clearance, roadmap.clearance)
            planner.time_path(path, default_limits(RADIUS_M), clearance=roadmap.clearance)
    stranger = SceneObject(len(scene.objects) + 1, (CircleRecord((1.0, 0.4), 0.05),))
    known = roadmap.updated(replace(scene, objects=(*scene.objects, stranger)))
    known.updated(scene)


def _picture(config: Config) -> tuple[np.ndarray, np.ndarray]:
    """A floor with the robot's marker, a square and a disc; and the same with more noise."""
    noise = np.random.default_rng(0).normal(0.0, 2.0, (2, SIZE_PX[1], SIZE_PX[0]))
    picture = np.full((SIZE_PX[1], SIZE_PX[0]), 225, np.uint8)
    picture[130:180, 180:230] = 25
    cv2.circle(picture, (300, 230), 25, 25, -1)
    book = dictionary_by_name(config.robot.dictionary)
    marker = cv2.aruco.generateImageMarker(book, config.robot.marker_id, MARKER_PX)
    if config.vision.polarity == "light":
        picture = 255 - picture
    picture[202:258, 42:98] = 225  # the marker's quiet zone, whatever the floor is
    picture[210 : 210 + MARKER_PX, 50 : 50 + MARKER_PX] = marker
    first, second = (np.clip(picture + n, 0, 255).astype(np.uint8) for n in noise)
    return first, second
