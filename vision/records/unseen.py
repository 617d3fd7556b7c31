"""Ground that no camera sees now: unknown, so a scene holds it as an obstacle.

Rules
- A plan of the ground gives the unseen share of each pixel: a lens folds or looks sideways there
  (``vision.calibration.blind``), or no working camera looks there (``vision.joined.floor_plan``).
  It is outlined like any picture and added to the scene's objects: robots do not drive on unseen
  ground.
- A lens's blind pixels get the picture's middle grey before a level is sought, so that they show
  neither edges nor obstacles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Bounds, Scene, SceneObject
from vision.picture_error import PictureError

_BLUR_PX = 3.0
"""Sigma of the blur of a lens's plan: its outline needs few edges; the blind part is grown by more
than twice that."""
_MOST_KNOWN = 16


@dataclass(frozen=True, slots=True)
class Unseen:
    """Unseen ground in metres, and the sentence on it."""

    objects: tuple[SceneObject, ...] = ()
    said: str = ""


_KNOWN: dict[tuple[object, Bounds], Unseen] = {}


def blind_of(calibration: object) -> NDArray[np.bool_] | None:
    """Blind pixels (h, w) of a calibration; a caller's own need not know any."""
    blind: NDArray[np.bool_] | None = getattr(calibration, "blind", None)
    return blind if blind is not None and blind.any() else None


def without_blind(image: NDArray[Any], blind: NDArray[np.bool_]) -> NDArray[Any]:
    """Copy of a picture (h, w) or (h, w, c) whose blind pixels have the others' median.

    A picture of another size is returned as it is. Raises ``PictureError`` if no pixel is seen.
    """
    if image.shape[:2] != blind.shape:
        return image  # its placement reports the calibration's size
    if blind.all():
        raise PictureError("the picture shows no ground: the lens folds all over it")
    filled = image.copy()
    filled[blind] = np.median(image[~blind], axis=0).astype(image.dtype)
    return filled


def unseen_ground(
    shares: NDArray[Any], plan: object, bounds: Bounds, outline: Callable[..., Scene]
) -> tuple[SceneObject, ...]:
    """Ground that no camera sees, from a plan (h, w) of shares 0 .. 1, as objects in metres.

    ``plan`` is the calibration of the plan's pixels, ``outline`` is ``vision.extract``.
    """
    drawn = np.rint(255.0 * (1.0 - shares)).astype(np.uint8)
    return outline(drawn, method="fixed", threshold=128, calibration=plan, bounds=bounds).objects


def hidden_by_lens(calibration: object, bounds: Bounds, outline: Callable[..., Scene]) -> Unseen:
    """Ground in the bounds that a camera's lens hides; ``outline`` is ``vision.extract``.

    Raises ``PictureError`` if nothing within the bounds is seen. Cached.
    """
    blind = blind_of(calibration)
    if blind is None or not hasattr(calibration, "blind_plan"):
        return Unseen()
    if (calibration, bounds) not in _KNOWN:
        while len(_KNOWN) >= _MOST_KNOWN:
            _KNOWN.pop(next(iter(_KNOWN)), None)
        objects = _hidden(calibration, bounds, outline)
        where = "and its ground is an obstacle" if objects else "outside the bounds"
        _KNOWN[calibration, bounds] = Unseen(
            objects,
            f"{100.0 * float(blind.mean()):.0f} % of the picture is unknown, where the lens folds "
            f"or looks sideways, {where}",
        )
    return _KNOWN[calibration, bounds]


def _hidden(
    calibration: Any, bounds: Bounds, outline: Callable[..., Scene]
) -> tuple[SceneObject, ...]:
    plan = calibration.blind_plan(bounds)
    if plan is None:
        return ()
    blind, plan_calibration = plan
    if blind.all():
        raise PictureError("nothing within the bounds is seen: the lens folds, or looks elsewhere")
    shares = cv2.GaussianBlur(blind.astype(np.float32), (0, 0), _BLUR_PX)
    return unseen_ground(shares, plan_calibration, bounds, outline)


def with_unseen(scene: Scene, unseen: Unseen) -> Scene:
    """Add unseen ground to a scene's objects, and its sentence to the remarks."""
    if not unseen.said:
        return scene
    first = 1 + max((o.id for o in scene.objects), default=-1)
    added = tuple(replace(o, id=first + i) for i, o in enumerate(unseen.objects))
    return replace(scene, objects=(*scene.objects, *added), remarks=(*scene.remarks, unseen.said))
