"""The pictures of the network camera, true or not. Metres, radians, seconds since the fault.

A lie about the place shows the whole robot elsewhere; the true one is drawn where the fault says
that it is still to be seen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np

from navigation.config import Config
from navigation.simulator.arena import SimulatedArena, load_arena
from navigation.simulator.picture.camera import SimulatedBody, SimulatedCamera, TruePose
from navigation.simulator.picture.drawing import Appearance
from navigation.simulator.picture.pinhole import Pinhole, pinhole_of
from planner.scene import FloatArray
from vision.camera.camera import Image

AWAY: TruePose = (-50.0, -50.0, 0.0)
"""Out of every picture."""
SHIFT_BITS = 6
"""Binary digits of a pixel to which a bar's corners are drawn."""
CARD_RADIUS_M = 0.08
CARD_GREY = 120.0
LAID_SHARE = 0.2
"""The share of the floor's light that a bar takes away; obstacles take four fifths."""


@dataclass(frozen=True, slots=True)
class Faults:
    """What is wrong with the camera now; the defaults are a good one.

    ``lie_m``: the robot is shown so far (x, y) from where it is; it gets there with
    ``lie_m_s`` (0.0: at once). ``shown_at``: it is shown standing there (x, y, heading_rad).
    ``every``: such a lie is told in one picture of so many. ``double_at``: a second robot with
    the same marker; ``covered``: a card lies on the true marker. ``blink``: (seen_s, hidden_s).
    ``laid``: the corners of a faint bar on the floor (x0, y0, x1, y1 ...), which no fault is.
    """

    frozen: str = ""
    """``clock``: the old picture with a running clock; ``noise``: with fresh noise; ``exact``."""
    latency_s: float = 0.0
    loop_s: float = 0.0
    lie_m: tuple[float, float] = (0.0, 0.0)
    lie_m_s: float = 0.0
    shown_at: TruePose | None = None
    every: int = 1
    double_at: TruePose | None = None
    covered: bool = False
    laid: tuple[float, ...] = ()
    blink: tuple[float, float] | None = None
    turned: bool = False
    moved_m: tuple[float, float] = (0.0, 0.0)
    stalled: bool = False
    dead: bool = False
    truncated: bool = False
    size_px: tuple[int, int] | None = None


class Film:
    """Draws what the camera shows."""

    def __init__(self, config: Config, rng: np.random.Generator) -> None:
        self._config, self._rng = config, rng
        self._pinhole = pinhole_of(config)
        self._arena = load_arena(config)
        self._cameras: dict[tuple[float, float], SimulatedCamera] = {}
        self._camera((0.0, 0.0))
        self._still: Image | None = None
        self._still_pose: TruePose = AWAY
        self._count = 0

    def picture(self, pose: TruePose, faults: Faults, since_s: float) -> Image:
        """One picture, of the robot at ``pose``, ``since_s`` after the fault began."""
        self._count += 1
        if not faults.frozen:
            self._still = None
        shown = self._shown(pose, faults, since_s)
        if faults.frozen:
            return self._frozen(pose, faults)
        camera = self._camera(faults.moved_m)
        upright, turned = (AWAY, shown) if faults.turned else (shown, AWAY)
        picture = camera.render([upright, faults.double_at or AWAY, turned], self._rng)
        if faults.laid:
            self._lay(picture, np.reshape(faults.laid, (-1, 2)))
        if faults.covered or _is_hidden(faults.blink, since_s):
            self._cover(picture, shown)
        if faults.size_px is not None:
            picture = np.asarray(cv2.resize(picture, faults.size_px), dtype=np.uint8)
        return picture

    def _shown(self, pose: TruePose, faults: Faults, since_s: float) -> TruePose:
        if self._count % faults.every:
            return pose
        if faults.shown_at is not None:
            return faults.shown_at
        way_m = math.hypot(*faults.lie_m)
        if way_m == 0.0:
            return pose
        share = min(1.0, since_s * faults.lie_m_s / way_m) if faults.lie_m_s else 1.0
        return pose[0] + share * faults.lie_m[0], pose[1] + share * faults.lie_m[1], pose[2]

    def _frozen(self, pose: TruePose, faults: Faults) -> Image:
        camera = self._camera((0.0, 0.0))
        if self._still is None:
            self._still, self._still_pose = camera.render([pose, AWAY, AWAY], self._rng), pose
        if faults.frozen == "noise":
            return camera.render([self._still_pose, AWAY, AWAY], self._rng)
        picture = self._still.copy()
        if faults.frozen == "clock":
            text = f"12:00:{self._count / 25.0:06.3f}"
            cv2.rectangle(picture, (2, 2), (150, 22), 200, -1)
            cv2.putText(picture, text, (5, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.5, 150, 1)
        return picture

    def _lay(self, picture: Image, corners_m: FloatArray) -> None:
        """A faint bar on the floor, over what of a robot's body is seen there."""
        assert self._config.simulation is not None
        seen = self._pinhole.image_from_arena(corners_m)
        bar = np.zeros(picture.shape, np.float32)
        at = np.rint(seen * (1 << SHIFT_BITS)).astype(np.int32)
        cv2.fillConvexPoly(bar, at, 1.0, cv2.LINE_AA, SHIFT_BITS)
        darker = LAID_SHARE * cv2.GaussianBlur(bar, (0, 0), self._config.simulation.camera.blur_px)
        picture[:] = np.rint(picture * (1.0 - darker))

    def _cover(self, picture: Image, pose: TruePose) -> None:
        """A plain card on the robot's top."""
        turns = np.linspace(0.0, math.tau, 40, endpoint=False)
        rim = CARD_RADIUS_M * np.column_stack([np.cos(turns), np.sin(turns)]) + pose[:2]
        seen = self._pinhole.image_from_arena(rim, self._config.robot.marker_height_m)
        cv2.fillConvexPoly(picture, np.rint(seen).astype(np.int32), CARD_GREY)

    def _camera(self, moved_m: tuple[float, float]) -> SimulatedCamera:
        """The camera where it hangs, or where somebody has pushed it."""
        if moved_m not in self._cameras:
            away = np.array([*moved_m, 0.0])
            pinhole = replace(self._pinhole, position_m=self._pinhole.position_m + away)
            self._cameras[moved_m] = _camera_of(self._config, pinhole, self._arena)
        return self._cameras[moved_m]


def _is_hidden(blink: tuple[float, float] | None, since_s: float) -> bool:
    return blink is not None and since_s % sum(blink) >= blink[0]


def _camera_of(config: Config, pinhole: Pinhole, arena: SimulatedArena) -> SimulatedCamera:
    """A camera that draws the robot, its double, and the robot with its marker turned."""
    assert config.simulation is not None
    settings, robot = config.simulation.camera, config.robot
    bodies = [
        SimulatedBody(
            robot.marker_id, robot.marker_size_m, robot.marker_height_m, robot.radius_m,
            robot.dictionary, turn_rad, lambda _at_s: AWAY,
        )
        for turn_rad in (0.0, 0.0, math.pi)
    ]  # fmt: skip
    look = Appearance(
        settings.blur_px, settings.noise_grey, settings.light_fall, config.vision.polarity
    )
    return SimulatedCamera(pinhole, arena.scene, bodies, look, lambda: 0.0)
