"""The watch over an arena of known things: what it shows, and what came and went.

- A thing is known once part of its outline is in the picture and not below a believed robot. A body
  is such a thing if the eye believes no robot there.
- Things below a robot stay as last seen; a change is reported when two frames in a row show one.

Metres, raw pixels.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from navigation.run.without_pictures.sights import PICTURE_SHAPE, Sights, TrueSight
from planner.scene import CircleRecord, FloatArray, Scene, SceneObject
from vision.calibration.calibration import Calibration
from vision.camera.camera import Image
from vision.watch.change import Change, SceneWatcher
from vision.watch.refit import outline_points

COVERED_PX: Final = 4.0
"""Least size of the picture's cells, which a robot covers wherever it touches them."""
STEP_M: Final = 0.01
"""A body that has moved by less shows no change."""


@dataclass(frozen=True, slots=True, eq=False)
class Thing:
    """Anything but floor; ``outline_px`` (n, 2) is the part that this camera shows."""

    seen: SceneObject
    outline_px: FloatArray


Things: TypeAlias = dict[int, Thing]
"""By a number that a thing keeps."""


class TrueWatcher(SceneWatcher):
    """`SceneWatcher` that gets what one camera can see."""

    def __init__(self, sights: Sights, calibration: Calibration) -> None:
        super().__init__()
        self._sights, self._calibration = sights, calibration
        self._blind = calibration.blind
        self._scene: Scene | None = None
        self._arena: Things = {}
        self._known: Things | None = None
        self._waits = False

    @property
    def things(self) -> Things:
        """All reported things."""
        return self._known or {}

    @property
    def background(self) -> Image:
        """A blank picture: there is none of the arena."""
        return np.zeros(PICTURE_SHAPE, np.uint8)

    def update(self, image: Image, bodies: ArrayLike | None) -> Change | None:
        """Return the change that a frame shows; None if nothing is new."""
        if bodies is None:
            return None
        discs = np.asarray(bodies, dtype=np.float64).reshape(-1, 3)
        there = self._there(self._sights.of(image), discs)
        known = self._known
        if known is None:
            self._known = {i: one for i, one in there.items() if not _is_covered(one, discs)}
            return Change((), first=True)
        if there.keys() == known.keys():
            self._waits = False
            return None
        gone = [i for i in known.keys() - there.keys() if not _is_covered(known[i], discs)]
        new = [i for i in there.keys() - known.keys() if not _is_covered(there[i], discs)]
        if not (gone or new):
            self._waits = False
            return None
        if not self._waits:
            self._waits = True
            return None
        self._waits = False
        self._known = {i: one for i, one in known.items() if i not in gone}
        self._known |= {i: there[i] for i in sorted(new)}
        return Change(())

    def _there(self, sight: TrueSight, discs: FloatArray) -> Things:
        if sight.scene is not self._scene:
            self._scene = sight.scene
            self._arena = {}
            for one in sight.scene.objects:
                self._add(self._arena, (one.records, one.holes), one)
        strange = self._uncovered(sight.bodies, discs)
        if not len(strange):
            return self._arena
        there = dict(self._arena)
        for x, y, radius in strange.tolist():
            at = (STEP_M * round(x / STEP_M), STEP_M * round(y / STEP_M))
            body = SceneObject(0, (CircleRecord(at, radius),))
            self._add(there, body.records, body)
        return there

    def _add(self, things: Things, key: Hashable, one: SceneObject) -> None:
        outline = self._calibration.image_from_arena(outline_points(one))
        shown = outline[self._in_picture(outline)]
        if len(shown):
            number = self._sights.number_of(key)
            things[number] = Thing(SceneObject(number, one.records, one.holes), shown)

    def _in_picture(self, pixels: FloatArray) -> NDArray[np.bool_]:
        """True (n,) for pixels in the picture that show the floor."""
        with np.errstate(invalid="ignore"):
            within = (pixels >= 0.0) & (pixels <= np.array(self._calibration.size) - 1.0)
        inside: NDArray[np.bool_] = np.logical_and(within[:, 0], within[:, 1])
        if self._blind is not None:
            x, y = np.rint(pixels[inside]).astype(np.int64).T
            inside[inside] = ~self._blind[y, x]
        return inside

    def _uncovered(self, bodies: FloatArray, discs: FloatArray) -> FloatArray:
        """Bodies (n, 3) at places where the eye believes no robot."""
        middles, rights = bodies[:, :2], bodies[:, :2] + bodies[:, 2:] * (1.0, 0.0)
        pixels = self._calibration.image_from_arena(np.concatenate([middles, rights]))
        at, right = pixels[: len(bodies)], pixels[len(bodies) :]
        radius = np.hypot(*(right - at).T)
        away = at[:, None] - discs[None, :, :2]
        with np.errstate(invalid="ignore"):
            deepest = np.hypot(away[..., 0], away[..., 1]) + radius[:, None] - discs[None, :, 2]
            covered = (deepest <= COVERED_PX).any(axis=1)
        return np.asarray(bodies[~covered & self._in_picture(at)])


def _is_covered(thing: Thing, discs: FloatArray) -> bool:
    """True if robots hide all that the camera would show of a thing."""
    away = thing.outline_px[:, None] - discs[None, :, :2]
    return bool((np.hypot(away[..., 0], away[..., 1]) <= discs[:, 2]).any(axis=1).all())
