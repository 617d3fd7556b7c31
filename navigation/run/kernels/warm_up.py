"""Compile or load every kernel before the robot may move.

A small arena goes through the daemon's own parts. A kernel first needed during a drive would cost a
moving robot half a second. Loading takes about a second, once in a process; the first time on a
machine, two processes compile.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache

import cv2
import numpy as np

from navigation.config import Config
from navigation.config.sections import RobotSection, VisionSection
from navigation.loop.planning import ArenaPlanner, PlanSettings
from navigation.loop.seeing.eye import Eye, EyeSettings, RobotShape
from navigation.mission.cycle import PlanRequest
from navigation.mission.mission import Station
from navigation.mission.traffic import Disc
from navigation.run.kernels.compiling import CompileProgress, compile_parts
from navigation.run.kernels.plan_together import plan_together
from navigation.shared.garbage import resume_collection
from planner.delaunay.insertion_kernels import triangulate
from planner.motion.trajectory import default_limits
from planner.path import NoPath
from planner.scene import (
    Arc,
    Bounds,
    CircleRecord,
    PolygonRecord,
    Scene,
    SceneObject,
    Segment,
)
from planner.shared.kernel_locator import is_compiled
from vision.binarise.binarise import warm_up as warm_up_binarisation
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame, Image
from vision.markers.markers import MarkedRobot, MarkerTracker, dictionary_by_name
from vision.outline.fitting_kernels import fit_borders

SIZE_PX = (400, 300)
METRES_PER_PIXEL = 0.005
MARKER_PX = 40
RADIUS_M = 0.15
BODY_RADIUS_M = 0.22
"""Holds the marker with its quiet zone."""
BOUNDS = Bounds(0.0, 0.0, 2.0, 1.5)
SLIGHT_LENS = (-1e-3, 0.0, 0.0, 0.0, 0.0)
"""Any distortion takes other branches of the calibration than none."""
EMPTY_FRAMES, CHANGED_FRAMES = 5, 4
STARTS = ((0.3, 0.3, 0.0), (0.4, 1.2, 0.5))
GOAL = Station(1.7, 1.2, 0.3)
SAY_EVERY_S = 10.0
WAYSIDE = (Station(1.0, 0.2), Station(0.5, 0.6), Station(1.75, 0.6))


def warm_up(config: Config, say: Callable[[str], None]) -> None:
    """Run eye and planner; ``say`` gets lines of news."""
    if kernels_are_cold():
        say("compiling the kernels, once on this machine: some minutes")
        say_now_and_then(compile_kernels(config), say)
    _load(config.vision, config.robot)
    if config.robots:
        plan_together(config)
    resume_collection()  # from here on what remains of a picture or a message is garbage, too


def say_now_and_then(
    compilation: Iterator[CompileProgress], say: Callable[[str], None]
) -> CompileProgress:
    """Compile to the end, with a line every ``SAY_EVERY_S``; return the final progress."""
    shown_s = 0.0
    for progress in compilation:
        if progress.passed_s - shown_s >= SAY_EVERY_S:
            shown_s = progress.passed_s
            say(f"  {progress}")
    if progress.failed:
        say(f"  {' and '.join(progress.failed)} not compiled: it is done here")
    say(f"  {progress.done} kernels compiled after {progress.passed_s:.0f} s")
    return progress


def compile_kernels(config: Config) -> Iterator[CompileProgress]:
    """Compile a run's kernels in processes beside this one; yield the progress."""
    return compile_parts({"eye": (compile_eye, (config,)), "planner": (compile_planner, ())})


def compile_eye(config: Config) -> None:
    """Send pictures with every kind of border through the eye, for its kernels."""
    _see(config.vision, config.robot)


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
    scene = Scene("m", BOUNDS, objects)
    stranger = SceneObject(2, (CircleRecord((1.0, 0.4), 0.05),))
    _run_planner([scene, replace(scene, objects=(*objects, stranger)), scene])


def kernels_are_cold() -> bool:
    """True if kernels compiled for this processor from these sources are missing."""
    return not (is_compiled(triangulate) and is_compiled(fit_borders))


@cache  # a configuration that is read again finds them loaded
def _load(vision: VisionSection, robot: RobotSection) -> None:
    """Load the compiled kernels that these sections need, and compile any that failed."""
    _run_planner(_see(vision, robot))


def _see(vision: VisionSection, robot: RobotSection) -> list[Scene]:
    """The three scenes of an arena in which a disc appears and disappears."""
    warm_up_binarisation(vision.polarity)
    flat = Calibration.from_scale(METRES_PER_PIXEL, SIZE_PX)
    calibration = replace(flat, distortion=np.array(SLIGHT_LENS))
    marked = MarkedRobot(robot.marker_id, MARKER_PX * METRES_PER_PIXEL)
    eye = Eye(
        calibration,
        MarkerTracker(calibration, [marked], robot.dictionary),
        EyeSettings(
            bounds_m=BOUNDS,
            vision=vision,
            driven_ids=(marked.id,),
            bodies={marked.id: RobotShape(BODY_RADIUS_M, 0.0)},
        ),
    )
    rng = np.random.default_rng(0)
    scenes = []
    for number in range(EMPTY_FRAMES + 2 * CHANGED_FRAMES):
        changed = 0 <= number - EMPTY_FRAMES < CHANGED_FRAMES
        picture = _picture(vision, robot, rng, stranger=changed)
        glimpse = eye.look(Frame(picture, number / 30.0, number, "warm-up"))
        if glimpse.scene is not None:
            scenes.append(glimpse.scene)
    return scenes


def _run_planner(scenes: Sequence[Scene]) -> None:
    in_the_way = Disc(1.0, 0.9, 0.1, 1, moves=False)
    for prefer in (0.0, 0.5, 1.0):
        limits = default_limits(RADIUS_M)
        arena_planner = ArenaPlanner(PlanSettings(RADIUS_M, 0.02, None, prefer, limits))
        for number, scene in enumerate(scenes, start=1):
            arena_planner.see(scene, number)
            for start in STARTS:
                arena_planner.clearance_m(start[:2])
                for avoid in ((), (in_the_way,)):
                    request = PlanRequest(number, start, (GOAL,), number, avoid=avoid)
                    answer = arena_planner.answer(request)
                    if not isinstance(answer.path, NoPath):
                        arena_planner.path_clearance_m(answer.path.points)
        arena_planner.answer(PlanRequest(0, STARTS[0], (*WAYSIDE, GOAL), 0, any_order=True))
    assert arena_planner.roadmap is not None
    _ = arena_planner.roadmap.graph  # loads networkx, which pages and the final picture need


def _picture(
    vision: VisionSection, robot: RobotSection, rng: np.random.Generator, *, stranger: bool
) -> Image:
    picture = np.full((SIZE_PX[1], SIZE_PX[0]), 225, np.uint8)
    picture[130:180, 180:230] = 25
    cv2.circle(picture, (300, 230), 25, 25, -1)
    if stranger:
        cv2.circle(picture, (200, 260), 15, 25, -1)
    book = dictionary_by_name(robot.dictionary)
    marker = cv2.aruco.generateImageMarker(book, robot.marker_id, MARKER_PX)
    if vision.polarity == "light":
        picture = 255 - picture
    picture[202:258, 42:98] = 225  # the marker's quiet zone on any floor
    picture[210 : 210 + MARKER_PX, 50 : 50 + MARKER_PX] = marker
    noisy = picture + rng.normal(0.0, 2.0, picture.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)
