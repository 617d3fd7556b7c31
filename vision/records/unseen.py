"""What a camera cannot see of its arena: unknown ground, which a scene holds as an obstacle.

Rules
- Blind pixels (``vision.calibration.blind``) are given the picture's middle grey before a level is
  sought: whatever a lens shows there twice, or not at all, is neither an edge nor an obstacle.
- The ground that they hide within the bounds is outlined as any picture is, from its plan, and
  added to the scene's objects, with a sentence: nobody drives on what nobody has seen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Bounds, Scene, SceneObject
from vision.errors import PictureError

_KNOWN: dict[tuple[object, Bounds], tuple[SceneObject, ...]] = {}
_MOST_KNOWN = 16
_BLUR_PX = 3.0
"""Of the plan, whose blind part is larger by more than twice of it: the outline needs few edges."""


def blind_of(calibration: object) -> NDArray[np.bool_] | None:
    """The blind pixels (h, w) of a calibration; a caller's own need not know any."""
    told: NDArray[np.bool_] | None = getattr(calibration, "blind", None)
    return told if told is not None and told.any() else None


def without_blind(image: NDArray[Any], blind: NDArray[np.bool_]) -> NDArray[Any]:
    """A copy of a picture (h, w) or (h, w, c) whose blind pixels have the others' median.

    One of another size stays as it is.

    Raises ``PictureError`` where no pixel is seen.
    """
    if image.shape[:2] != blind.shape:
        return image  # of another size than the calibration's, which its placement says
    if blind.all():
        raise PictureError("the picture shows no ground: the lens folds all over it")
    filled = image.copy()
    filled[blind] = np.median(image[~blind], axis=0).astype(image.dtype)
    return filled


def unseen_objects(
    calibration: object, bounds: Bounds, outline: Callable[..., Scene]
) -> tuple[SceneObject, ...]:
    """The unseen ground within the bounds as objects, metres; ``outline`` is ``vision.extract``.

    Raises ``PictureError`` where nothing within the bounds is seen. Made once, then remembered.
    """
    if not hasattr(calibration, "blind_plan"):
        return ()
    if (calibration, bounds) not in _KNOWN:
        while len(_KNOWN) >= _MOST_KNOWN:
            _KNOWN.pop(next(iter(_KNOWN)), None)
        _KNOWN[calibration, bounds] = _outlined(calibration, bounds, outline)
    return _KNOWN[calibration, bounds]


def _outlined(
    calibration: Any, bounds: Bounds, outline: Callable[..., Scene]
) -> tuple[SceneObject, ...]:
    plan = calibration.blind_plan(bounds)
    if plan is None:
        return ()
    blind, plan_calibration = plan
    if blind.all():
        raise PictureError("nothing within the bounds is seen: the lens folds, or looks elsewhere")
    drawn = cv2.GaussianBlur(np.where(blind, 0, 255).astype(np.uint8), (0, 0), _BLUR_PX)
    return outline(
        drawn, method="fixed", threshold=128, calibration=plan_calibration, bounds=bounds
    ).objects


def with_unseen(scene: Scene, unseen: tuple[SceneObject, ...], share: float) -> Scene:
    """The scene with its unseen ground; ``share`` of the picture is blind."""
    first = 1 + max((o.id for o in scene.objects), default=-1)
    added = tuple(replace(o, id=first + i) for i, o in enumerate(unseen))
    end = " and its ground is an obstacle" if unseen else ", outside the bounds"
    said = (
        f"{100.0 * share:.0f} % of the picture is unknown, where the lens folds or looks sideways"
    )
    return replace(scene, objects=(*scene.objects, *added), remarks=(*scene.remarks, said + end))
