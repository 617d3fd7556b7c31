"""The simulated overhead camera: pictures of the arena and its robots, 30 a second.

Dark obstacles lie flat on a light, unevenly lit floor. A robot is an upright cylinder with its
marker on top, in perspective through a distorting lens. Lens blur and sensor noise follow.

For speed, floor and obstacles are drawn once; a waiting frame gets a window of ready-made noise,
then the robots' patches. `captured_s` is the moment of exposure, which the robots' true poses
match.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from navigation.config import Config
from navigation.config.sections import MarkerSection, RobotSection
from navigation.config.simulation import SimulatedKnockSection
from navigation.config.values import FloorMarkerSection
from navigation.simulator.arena import SimulatedArena
from navigation.simulator.picture.drawing import Appearance, ArenaPainter, RobotPainter
from navigation.simulator.picture.pinhole import Pinhole, pinhole_of
from navigation.simulator.picture.timed_camera import TimedCamera, Wait
from planner.scene import Scene
from vision.camera.camera import Clock, Image
from vision.markers.marker_search import dictionary_by_name

TruePose: TypeAlias = tuple[float, float, float]
"""x, y in metres and the heading in radians."""
PoseAt: TypeAlias = Callable[[float], TruePose]
"""Pose at a moment of the clock, seconds, not long ago."""

NOISE_MARGIN_PX = 128
"""The noise bank is this much larger than a picture, so that windows of it differ."""
FLOOR_MARKER_RADII = 0.95
"""Radius of the disc that a floor marker covers, in sides of the marker: a white cell surrounds
it."""
NOISY_PX = 64
"""Average number of pixels that noise changes at which pictures never repeat: one without any comes
once in e^64."""


@dataclass(frozen=True, slots=True)
class SimulatedBody:
    """A robot to draw: marker, body and pose at any moment.

    One that ``lies`` is a marker on the floor and never moves.
    """

    marker_id: int
    marker_size_m: float
    marker_height_m: float
    radius_m: float
    dictionary: str
    marker_turn_rad: float
    pose_at: PoseAt
    lies: bool = False


class SimulatedCamera(TimedCamera["_Floor"]):
    """A camera that draws the simulated arena below; ``seed`` makes the noise repeatable."""

    def __init__(
        self,
        pinhole: Pinhole,
        scene: Scene,
        bodies: Sequence[SimulatedBody],
        look: Appearance,
        clock: Clock,
        wait: Wait = time.sleep,
        rate_hz: float = 30.0,
        latency_s: float = 0.0,
        seed: int = 0,
    ) -> None:
        self._arena_painter = ArenaPainter(pinhole, look)
        painters = [
            RobotPainter(
                pinhole, look, self._arena_painter, _marker_picture(body), body.radius_m,
                body.marker_size_m, body.marker_height_m, body.marker_turn_rad,
            )
            for body in bodies
        ]  # fmt: skip
        both = list(zip(painters, bodies, strict=True))
        self._lying = [(painter, body.pose_at(0.0)) for painter, body in both if body.lies]
        self._robot_painters = [painter for painter, body in both if not body.lies]
        self._bodies = tuple(body for body in bodies if not body.lies)
        self._look = look
        self._rng = np.random.default_rng(seed)
        self._noise = _noise_bank(pinhole.size_px, look.noise_grey, self._rng)
        # Unless eight bits show the noise, pictures are equal while nothing moves.
        may_repeat = _changed_px(self._noise, pinhole.size_px) < NOISY_PX
        super().__init__(clock, wait, rate_hz, latency_s, may_repeat=may_repeat)
        self._lock = threading.Lock()
        self._background = self._drawn(scene)
        self._to_come: list[tuple[float, Image]] = []

    def _prepare(self) -> _Floor:
        return self._floor(self._rng)

    def _expose(self, prepared: _Floor, captured_s: float) -> Image:
        return self._with_robots(prepared, [body.pose_at(captured_s) for body in self._bodies])

    def set_scene(self, scene: Scene) -> None:
        """Show another scene from the next frame; any thread may call."""
        background = self._drawn(scene)
        with self._lock:
            self._background = background

    def follow(self, scenes: Sequence[tuple[float, Scene]]) -> None:
        """Draw other scenes now, and show each from its moment of the clock."""
        drawn = [(from_s, self._drawn(scene)) for from_s, scene in scenes]
        with self._lock:
            self._to_come = sorted(drawn, key=lambda item: item[0])

    def _drawn(self, scene: Scene) -> Image:
        """The arena with the markers on its floor."""
        picture = self._arena_painter.picture(scene)
        for painter, pose in self._lying:
            painter.paint(picture, pose)
        return picture

    def render(self, poses: Sequence[TruePose], rng: np.random.Generator | None) -> Image:
        """Draw the picture (h, w) with the robots at ``poses``; no noise if ``rng`` is None."""
        return self._with_robots(self._floor(rng), poses)

    def _floor(self, rng: np.random.Generator | None) -> _Floor:
        """Draw the arena without robots ahead of the exposure."""
        now_s = self._next_s  # time of exposure
        with self._lock:
            while self._to_come and self._to_come[0][0] <= now_s:
                self._background = self._to_come.pop(0)[1]
            background = self._background
        if rng is None or self._look.noise_grey == 0.0:
            return _Floor(background.copy(), background, None)
        height, width = background.shape
        down, right = rng.integers(0, NOISE_MARGIN_PX, 2)
        noise = self._noise[:, down : down + height, right : right + width]
        return _Floor(_noisy(background, noise), background, noise)

    def _with_robots(self, floor: _Floor, poses: Sequence[TruePose]) -> Image:
        picture, noise = floor.picture, floor.noise
        painted = sorted(  # the robot nearest to the lens is painted last
            zip(self._robot_painters, poses, strict=True),
            key=lambda one: -one[0].from_lens_m(one[1]),
        )
        boxes = [painter.box(pose, picture.shape) for painter, pose in painted]
        parts = [np.s_[box[1] : box[3], box[0] : box[2]] for box in boxes if box is not None]
        for part in parts:
            picture[part] = floor.background[part]
        for painter, pose in painted:
            painter.paint(picture, pose)
        if noise is not None:
            clean = [picture[part].copy() for part in parts]  # two robots' boxes may overlap
            for part, pixels in zip(parts, clean, strict=True):
                picture[part] = _noisy(pixels, noise[:, *part])
        return picture


@dataclass(frozen=True, slots=True)
class _Floor:
    """A picture without robots: with noise, without it, and the noise itself (2, h, w)."""

    picture: Image
    background: Image
    noise: NDArray[np.uint8] | None


def _noisy(picture: Image, noise: NDArray[np.uint8]) -> Image:
    brighter = cv2.add(picture, noise[0])
    return np.asarray(cv2.subtract(brighter, noise[1], dst=brighter), dtype=np.uint8)


def _noise_bank(
    size_px: tuple[int, int], sigma: float, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """Amounts that noise adds and takes away, (2, h + margin, w + margin)."""
    width, height = size_px
    shape = (height + NOISE_MARGIN_PX, width + NOISE_MARGIN_PX)
    noise = np.rint(rng.normal(0.0, sigma, shape))
    return np.stack([np.clip(noise, 0, 255), np.clip(-noise, 0, 255)]).astype(np.uint8)


def _changed_px(noise: NDArray[np.uint8], size_px: tuple[int, int]) -> float:
    width, height = size_px
    share = np.count_nonzero(noise) / noise[0].size  # no pixel gets brighter and darker
    return float(share * width * height)


def _marker_picture(body: SimulatedBody) -> Image:
    """Cells of the marker, one pixel each, with its black border."""
    dictionary = dictionary_by_name(body.dictionary)
    cells = int(dictionary.markerSize) + 2
    return np.asarray(cv2.aruco.generateImageMarker(dictionary, body.marker_id, cells))


def _lying_at(marker: FloorMarkerSection) -> PoseAt:
    x, y = marker.place_m or (0.0, 0.0)
    pose = (x, y, float(np.deg2rad(marker.heading_deg or 0.0)))
    return lambda _at_s: pose


Driven: TypeAlias = Sequence[tuple[RobotSection, PoseAt]]
"""The driven robots, and their poses."""


def make_camera(
    config: Config,
    arena: SimulatedArena,
    driven: Driven,
    clock: Clock,
    wait: Wait = time.sleep,
    others: Sequence[PoseAt | None] = (),
    scenes: Sequence[tuple[float, Scene]] = (),
    knock: SimulatedKnockSection | None = None,
) -> SimulatedCamera:
    """Make the simulated camera of a configuration, after a ``knock`` if given.

    ``others`` give the pose of each of ``config.other_robots``, None if absent; by default none is
    drawn. ``scenes`` replace the arena's, each from its moment of the clock. Raises ``ValueError``
    without a section ``simulation`` and for another number of robots.
    """
    pinhole = pinhole_of(config, knock)
    assert config.simulation is not None
    settings = config.simulation.camera
    bodies = bodies_of(config, driven, others)
    look = Appearance(
        settings.blur_px, settings.noise_grey, settings.light_fall, config.vision.polarity
    )
    camera = SimulatedCamera(
        pinhole, arena.scene, bodies, look, clock, wait,
        config.camera.rate_hz, settings.latency_s, config.simulation.seed,
    )  # fmt: skip
    camera.follow(scenes)
    return camera


def bodies_of(
    config: Config, driven: Driven, others: Sequence[PoseAt | None] = ()
) -> list[SimulatedBody]:
    """All bodies in the arena with a marker; arguments as for `make_camera`.

    Raises ``ValueError`` for another number of other robots than configured.
    """
    robot = config.robot
    seen: list[tuple[MarkerSection, PoseAt, float]] = [
        (one, pose, float(np.deg2rad(one.marker_turn_deg))) for one, pose in driven
    ]
    seen += [
        (other, pose, 0.0)
        for other, pose in zip(config.other_robots, others, strict=bool(others))
        if pose is not None
    ]
    bodies = [
        SimulatedBody(
            one.marker_id, one.marker_size_m, one.marker_height_m, one.radius_m,
            robot.dictionary, turn, pose,
        )
        for one, pose, turn in seen
    ]  # fmt: skip
    return bodies + [
        SimulatedBody(
            one.marker_id, one.size_m, 0.0, FLOOR_MARKER_RADII * one.size_m, robot.dictionary,
            0.0, _lying_at(one), lies=True,
        )
        for one in config.arena.floor_markers
        if one.place_m is not None
    ]  # fmt: skip
