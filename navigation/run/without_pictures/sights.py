"""Views of a simulated camera, each kept under a number that its picture holds.

- A tiny picture's black and white cells hold the number. All that happens to pictures in transit
  (frozen, late, replayed, with fresh noise, a clock in the corner) happens to these too, and is
  noticed, or not, by the same code.
- Markers' corners are where the true lens puts them, with the real tracker's noise. A marker is not
  seen if it leaves the picture or a body nearer to the lens hides a corner.

Metres, radians, seconds, raw pixels.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from navigation.config import Config
from navigation.simulator.arena import SimulatedArena
from navigation.simulator.picture.camera import NOISY_PX, Driven, PoseAt, SimulatedBody, bodies_of
from navigation.simulator.picture.pinhole import Pinhole, pinhole_of
from navigation.simulator.picture.timed_camera import TimedCamera
from planner.scene import FloatArray, Scene
from vision.camera.camera import Image

PICTURE_SHAPE: Final = (32, 128)
"""The upper half is left to the clock that some cameras draw."""
BITS: Final = 32
KEPT: Final = 20_000
"""Eleven minutes of one camera at 30 Hz: one frozen for longer shows nothing known."""
CORNER_PX: Final = 0.02
"""A corner's standard deviation along each axis, in pictures with noise of up to 2 grey levels.
The real tracker's poses are off by what 0.015 would make of them
(``tests/navigation/run/without_pictures/test_noise_of_poses.py``)."""
QUIET_GREY: Final = 2.0
RIM_PX: Final = 2.0
"""No marker is read this near to the picture's rim."""
FLATTEST: Final = math.tan(math.radians(89.0))
_UNIT_CORNERS: Final = np.array([(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)])


@dataclass(frozen=True, slots=True, eq=False)
class TrueSight:
    """The visible truth: bodies (n, 3) of x, y, radius; readable markers' corners (4, 2) by id."""

    scene: Scene
    bodies: FloatArray
    markers: tuple[tuple[int, FloatArray], ...]


class Sights:
    """Store of what cameras saw, under the numbers in their pictures."""

    def __init__(self) -> None:
        self._kept: dict[int, TrueSight] = {}
        self._count = 0
        self._numbers: dict[Hashable, int] = {}

    def keep(self, sight: TrueSight) -> Image:
        """Keep a sight and return its picture."""
        self._count += 1
        self._kept[self._count] = sight
        self._kept.pop(self._count - KEPT, None)
        bits = np.unpackbits(np.array([self._count], ">u4").view(np.uint8))
        row = np.repeat(bits * np.uint8(255), PICTURE_SHAPE[1] // BITS)
        picture = np.empty(PICTURE_SHAPE, np.uint8)
        picture[:] = row
        return picture

    def of(self, picture: Image) -> TrueSight:
        """Return the sight of a picture; ``ValueError`` if it has none."""
        cell = PICTURE_SHAPE[1] // BITS
        bits = picture[-1, cell // 2 :: cell] > 127
        number = int(np.packbits(bits).view(">u4")[0]) if picture.shape == PICTURE_SHAPE else 0
        if number not in self._kept:
            raise ValueError("the picture is none of those that stand for what was to be seen")
        return self._kept[number]

    def number_of(self, thing: Hashable) -> int:
        """Number of a thing, always the same."""
        return self._numbers.setdefault(thing, len(self._numbers))


class SightCamera(TimedCamera[Scene]):
    """A camera that reports what can be seen and draws nothing.

    ``scenes`` are the arena's, each from its moment of the clock on, the first at once.
    """

    def __init__(
        self,
        sights: Sights,
        pinhole: Pinhole,
        scenes: Sequence[tuple[float, Scene]],
        bodies: Sequence[SimulatedBody],
        config: Config,
        clock: Callable[[], float],
        wait: Callable[[float], None],
    ) -> None:
        assert config.simulation is not None
        settings = config.simulation.camera
        super().__init__(
            clock,
            wait,
            config.camera.rate_hz,
            settings.latency_s,
            may_repeat=_changed_px(settings.noise_grey, pinhole.size_px) < NOISY_PX,
        )
        self._sights, self._pinhole = sights, pinhole
        self._scenes = list(scenes)
        self._bodies = tuple(body for body in bodies if not body.lies)
        self._rng = np.random.default_rng(config.simulation.seed)
        self._corner_px = CORNER_PX * max(1.0, settings.noise_grey / QUIET_GREY)
        sizes = np.array([body.marker_size_m for body in self._bodies])
        self._upright = sizes[:, None, None] * _UNIT_CORNERS
        heights = np.array([body.marker_height_m for body in self._bodies])
        self._heights = np.repeat(heights, 4)
        self._limit_px = np.array(pinhole.size_px) - 1.0 - RIM_PX
        self._turns = np.array([body.marker_turn_rad for body in self._bodies])
        self._radii = np.array([body.radius_m for body in self._bodies])
        self._flattest = _flattest(pinhole)

    def _prepare(self) -> Scene:
        while len(self._scenes) > 1 and self._scenes[1][0] <= self._next_s:
            self._scenes.pop(0)
        return self._scenes[0][1]

    def _expose(self, prepared: Scene, captured_s: float) -> Image:
        poses = np.array([body.pose_at(captured_s) for body in self._bodies]).reshape(-1, 3)
        floor = self._marker_corners(poses)
        markers = self._seen(floor, poses)
        bodies = poses.copy()
        bodies[:, 2] = self._radii
        return self._sights.keep(TrueSight(prepared, bodies, markers))

    def _marker_corners(self, poses: FloatArray) -> FloatArray:
        """Corners (n, 4, 2), each at its marker's height."""
        angle = poses[:, 2] + self._turns
        c, s = np.cos(angle), np.sin(angle)
        turned = np.empty((len(poses), 2, 2))
        turned[:, 0, 0] = turned[:, 1, 1] = c
        turned[:, 0, 1], turned[:, 1, 0] = -s, s
        return np.asarray(poses[:, None, :2] + self._upright @ turned.swapaxes(1, 2))

    def _seen(self, floor: FloatArray, poses: FloatArray) -> tuple[tuple[int, FloatArray], ...]:
        count = len(self._bodies)
        points = np.empty((4 * count, 3))
        points[:, :2], points[:, 2] = floor.reshape(-1, 2), self._heights
        in_camera = self._pinhole.camera_from_points(points)
        pixels = self._pinhole.image_from_camera(in_camera)
        pixels = pixels.reshape(count, 4, 2) + self._rng.normal(0.0, self._corner_px, (count, 4, 2))
        flat = np.hypot(in_camera[:, 0], in_camera[:, 1]) <= self._flattest * in_camera[:, 2]
        inside = ((pixels >= RIM_PX) & (pixels <= self._limit_px)).all(axis=(1, 2))
        shown = inside & flat.reshape(count, 4).all(axis=1) & ~self._hidden(floor, poses)
        return tuple((self._bodies[i].marker_id, pixels[i]) for i in np.flatnonzero(shown))

    def _hidden(self, floor: FloatArray, poses: FloatArray) -> Any:
        """True (n,) if a body nearer to the lens hides a corner."""
        if len(poses) < 2:
            return np.zeros(len(poses), np.bool_)
        from_lens = np.hypot(*(poses[:, :2] - self._pinhole.position_m[:2]).T)
        away = floor[:, :, None, :] - poses[None, None, :, :2]
        under = (np.hypot(away[..., 0], away[..., 1]) < self._radii).any(axis=1)
        return (under & (from_lens[None, :] < from_lens[:, None])).any(axis=1)


def make_sight_camera(
    sights: Sights,
    config: Config,
    arena: SimulatedArena,
    driven: Driven,
    clock: Callable[[], float],
    wait: Callable[[float], None],
    others: Sequence[PoseAt | None] = (),
    scenes: Sequence[tuple[float, Scene]] = (),
    _knock: None = None,
) -> SightCamera:
    """Make a camera that draws nothing; arguments as for `make_camera`."""
    bodies = bodies_of(config, driven, others)
    over_time = [(-math.inf, arena.scene), *sorted(scenes, key=lambda item: item[0])]
    return SightCamera(sights, pinhole_of(config), over_time, bodies, config, clock, wait)


def _changed_px(noise_grey: float, size_px: tuple[int, int]) -> float:
    """Average number of pixels that noise would change."""
    if noise_grey <= 0.0:
        return 0.0
    return size_px[0] * size_px[1] * math.erfc(0.5 / (noise_grey * math.sqrt(2.0)))


def _flattest(pinhole: Pinhole) -> float:
    """Distance across over distance along the view of the picture's flattest ray."""
    width, height = pinhole.size_px
    x, y = np.linspace(-0.5, width - 0.5, 9), np.linspace(-0.5, height - 0.5, 9)
    rim = [(a, b) for a in x for b in (y[0], y[-1])] + [(a, b) for a in (x[0], x[-1]) for b in y]
    rays = np.hypot(*pinhole.rays(np.array(rim)).T)
    return FLATTEST if np.isnan(rays).any() else min(FLATTEST, 1.02 * float(rays.max()))
