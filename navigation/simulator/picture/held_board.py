"""A simulated camera before which a person moves a calibration board by hand.

Rules
- The board moves to a place, rests, and moves on: to the requested pose, or else through places,
  tilts and distances in an order shuffled by the seed. At rest only the noise changes.
- Lens, blur, light and noise are those of the simulation, so `clearway calibrate --live` finds the
  lens of `simulation.camera`.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from typing import Final

import cv2
import numpy as np

from navigation.config import Config
from navigation.simulator.picture.boards import BoardPainter, BoardPose
from navigation.simulator.picture.drawing import Appearance, FloatImage
from navigation.simulator.picture.pinhole import Pinhole, pinhole_of
from navigation.simulator.picture.timed_camera import TimedCamera, Wait
from planner.scene import Bounds, FloatArray, Scene
from vision.calibrate.board import BoardSpec
from vision.calibrate.covariance import KnownLens
from vision.calibrate.live.guide import HeldPose, held_poses
from vision.camera.camera import CameraError, Clock, Image

MOVE_S: Final = 0.7
REST_S: Final = 1.1
MOVING_SAMPLES: Final = 2
"""Samples a pixel and side of a moving board; it is never measured."""


class HeldBoardCamera(TimedCamera[None]):
    """Camera with a hand-held board; ``asked`` gives its requested pose, or None."""

    name = "simulated camera and board"

    def __init__(
        self,
        config: Config,
        spec: BoardSpec,
        clock: Clock,
        wait: Wait = time.sleep,
        seed: int = 0,
        asked: Callable[[], HeldPose | None] = lambda: None,
    ) -> None:
        if config.simulation is None:
            raise CameraError("the configuration has no section 'simulation'")
        super().__init__(clock, wait, config.camera.rate_hz, latency_s=0.0, may_repeat=False)
        camera = config.simulation.camera
        self._pinhole = pinhole_of(config)
        look = Appearance(camera.blur_px, camera.noise_grey, camera.light_fall)
        empty = Scene("m", Bounds(*config.arena.bounds_m), ())
        self._painter = BoardPainter(self._pinhole, look, spec, empty)
        self._noise_grey = camera.noise_grey
        self._rng = np.random.default_rng(seed)
        held = held_poses(_true_lens(self._pinhole), spec)
        if not held:
            raise CameraError(f"{self.name}: the board is nowhere wholly in the picture")
        order = self._rng.permutation(len(held))
        self._spec, self._asked = spec, asked
        self._others = itertools.cycle([self._board_pose(held[i]) for i in order])
        self._last_asked: HeldPose | None = None
        self._here = self._there = next(self._others)
        self._stage = 0
        self._resting: FloatImage | None = None
        self._began_s = 0.0

    def open(self) -> None:
        """Start giving frames."""
        super().open()
        self._began_s = self._next_s

    def _prepare(self) -> None:
        """Nothing: the person moves the board until the exposure."""

    def _expose(self, prepared: None, captured_s: float) -> Image:
        picture = self._picture(captured_s - self._began_s)
        noise = self._rng.standard_normal(picture.shape, dtype=np.float32)
        return np.clip(np.rint(picture + self._noise_grey * noise), 0, 255).astype(np.uint8)

    def _picture(self, passed_s: float) -> FloatImage:
        number, within_s = divmod(passed_s, REST_S + MOVE_S)
        stage = 2 * int(number) + (within_s > REST_S)
        if stage != self._stage:
            self._here, self._resting = self._there, None
            if stage % 2:
                self._there = self._next()
            self._stage = stage
        if stage % 2:
            share = (within_s - REST_S) / MOVE_S
            return self._painter.clean(_between(self._here, self._there, share), MOVING_SAMPLES)
        if self._resting is None:
            self._resting = self._painter.clean(self._here)
        return self._resting

    def _next(self) -> BoardPose:
        """The requested pose; another if the same request was just tried without a view."""
        asked = self._asked()
        if asked is None or asked is self._last_asked:
            return next(self._others)
        self._last_asked = asked
        return self._board_pose(asked)

    def _board_pose(self, held: HeldPose) -> BoardPose:
        """Convert the camera's view of the first inner corner to the sheet's lower left one."""
        camera_from_board = np.asarray(cv2.Rodrigues(held.turn)[0], dtype=np.float64)
        arena_from_camera = self._pinhole.camera_from_arena.T
        arena_from_board = arena_from_camera @ camera_from_board
        first = self._pinhole.position_m + arena_from_camera @ held.shift
        square_m = self._spec.square_m
        corner = np.array([-square_m, square_m - self._spec.size_m[1], 0.0])
        return BoardPose(arena_from_board, first + arena_from_board @ corner)


def _true_lens(pinhole: Pinhole) -> KnownLens:
    return KnownLens(
        pinhole.size_px, np.array(pinhole.matrix), np.array(pinhole.distortion), np.eye(9), 1.0
    )


def _between(here: BoardPose, there: BoardPose, share: float) -> BoardPose:
    """A hand's path: slow at both ends."""
    eased = share * share * (3.0 - 2.0 * share)
    turn = np.asarray(cv2.Rodrigues(here.arena_from_board.T @ there.arena_from_board)[0])
    step: FloatArray = np.asarray(cv2.Rodrigues(turn * eased)[0], dtype=np.float64)
    origin = here.origin_m + (there.origin_m - here.origin_m) * eased
    return BoardPose(here.arena_from_board @ step, origin)
