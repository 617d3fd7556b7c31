"""A scene brought up to date: only what changed is fitted again.

Rules and units
- Rectangles are (x, y, width, height) in raw pixels, from ``vision.watch.change``; the scene is in
  metres.
- Each changed rectangle grows until it cuts no known object. Its content is extracted again at the
  scene's own level; everything else keeps its records, to the bit, and its id.
- Where that cannot be trusted (uneven light, half of the picture changed, an object that leaves its
  part, edges that the level does not separate), the caller extracts the whole picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from planner.scene import Arc, Binarisation, PointRecord, Scene, SceneObject, record_edges
from vision.binarise import ONE_LEVEL
from vision.binarise.earlier_level import level_leaves_out
from vision.calibration.calibration import Calibration, FloatArray
from vision.camera.camera import Image
from vision.doubts import doubts_about, with_doubts
from vision.picture_error import PictureError
from vision.pipeline import extract
from vision.records.unseen import Unseen, blind_of, hidden_by_lens
from vision.watch.change import Rectangle

_MARGIN_PX = 12
"""Margin around a change: a profile across an edge is this long, and a part must have floor."""

_OBJECT_MARGIN_PX = 6
_POINTS_AN_ARC = 65
"""A whole circle's box is short by a thousandth of its radius."""

_POINTS_A_LINE = 9
"""A lens bends a straight edge in the picture."""

_MOST_SHARE = 0.5
"""Share of the picture beyond which all of it is as quick."""

_Box = tuple[int, int, int, int]
_NOWHERE: _Box = (0, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class _Part:
    """Calibration of a part of the picture that begins at (``x``, ``y``)."""

    whole: Calibration
    x: int
    y: int
    blind: NDArray[np.bool_] | None

    @property
    def metres_per_pixel(self) -> float:
        """Scale of the whole picture: tolerances must be the same."""
        return self.whole.metres_per_pixel

    def arena_from_image(self, points_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert points of the part (n, 2) to metres."""
        return self.whole.arena_from_image(np.asarray(points_px) + np.array([self.x, self.y]))


@dataclass(frozen=True, slots=True)
class KnownScene:
    """A scene in metres, and the pixels that hold each of its objects."""

    scene: Scene
    calibration: Calibration
    boxes: tuple[_Box, ...]

    @classmethod
    def of(
        cls,
        scene: Scene,
        calibration: Calibration,
        unseen: Unseen | None = None,
    ) -> KnownScene:
        """Known scene of an extracted ``scene``; ``unseen`` defaults to the lens's. O(records)."""
        unseen = unseen or hidden_by_lens(calibration, scene.bounds, extract)
        hidden = {o.records for o in unseen.objects}
        boxes = _boxes_of(scene.objects, calibration)
        # unseen ground belongs to no picture, and stays
        found = zip(scene.objects, boxes, strict=True)
        kept = tuple(_NOWHERE if o.records in hidden else b for o, b in found)
        return cls(scene, calibration, kept)

    def refitted(self, image: Image, rectangles: Sequence[Rectangle]) -> KnownScene | None:
        """Scene of ``image``, which differs in ``rectangles`` only; None if all must be extracted.

        ``border_pixels``, ``timings_ms`` and ``remarks`` are those of the parts. O(pixels of the
        parts).
        """
        scene, size = self.scene, (image.shape[1], image.shape[0])
        how = scene.binarisation
        if how is None or how.method not in ONE_LEVEL or scene.size != size:
            return None
        parts = _parts(rectangles, self.boxes, size)
        if sum((x1 - x0) * (y1 - y0) for x0, y0, x1, y1 in parts) > _MOST_SHARE * size[0] * size[1]:
            return None
        found: list[Scene] = []
        boxes: list[_Box] = []
        for part in parts:
            fresh = self._extract(image, part, how)
            if fresh is None:
                return None
            inside = _boxes_of(fresh.objects, self.calibration)
            if any(_leaves(box, part, size) for box in inside):
                return None
            found.append(fresh)
            boxes += inside
        stays = [not any(_meet(box, part) for part in parts) for box in self.boxes]
        kept = [o for o, stay in zip(scene.objects, stays, strict=True) if stay]
        boxes = [b for b, stay in zip(self.boxes, stays, strict=True) if stay] + boxes
        joined = _joined(scene, kept, found)
        return KnownScene(joined, self.calibration, tuple(boxes))

    def _extract(self, image: Image, part: _Box, how: Binarisation) -> Scene | None:
        x0, y0, x1, y1 = part
        if level_leaves_out(image[y0:y1, x0:x1], how):
            return None
        blind = blind_of(self.calibration)
        part_blind = None if blind is None else blind[y0:y1, x0:x1]
        try:
            return extract(
                image[y0:y1, x0:x1],
                polarity=how.polarity,
                method="fixed",
                threshold=how.threshold,
                calibration=_Part(self.calibration, x0, y0, part_blind),
                bounds=self.scene.bounds,
            )
        except PictureError:
            return None


def _joined(scene: Scene, kept: Sequence[SceneObject], found: Sequence[Scene]) -> Scene:
    """Join the objects that stay with those of the parts, under unused ids."""
    free_id = 1 + max((o.id for o in scene.objects), default=-1)
    new = [o for fresh in found for o in fresh.objects]
    laps: dict[str, float] = {}
    for fresh in found:
        for name, ms in fresh.timings_ms.items():
            laps[name] = laps.get(name, 0.0) + ms
    said = [r for fresh in found for r in fresh.remarks if r not in doubts_about(fresh)]
    joined = replace(
        scene,
        objects=(*kept, *(replace(o, id=free_id + i) for i, o in enumerate(new))),
        border_pixels=sum(fresh.border_pixels for fresh in found),
        timings_ms=laps,
        remarks=tuple(dict.fromkeys(said)),
    )
    return with_doubts(joined)


def _boxes_of(objects: Sequence[SceneObject], calibration: Calibration) -> tuple[_Box, ...]:
    if not objects:
        return ()
    outlines = [outline_points(obj) for obj in objects]
    starts = np.cumsum([0, *(len(o) for o in outlines[:-1])])
    seen = calibration.image_from_arena(np.concatenate(outlines))
    width, height = calibration.size
    hidden = ~np.isfinite(seen)
    low = np.minimum.reduceat(np.where(hidden, np.inf, seen), starts)
    high = np.maximum.reduceat(np.where(hidden, -np.inf, seen), starts)
    low = np.floor(low.clip(-1, (width, height))).astype(int)
    high = np.ceil(high.clip(-1, (width, height))).astype(int) + 1
    low, high = np.maximum(low, 0), np.minimum(high, (width, height))
    return tuple((x0, y0, x1, y1) for x0, y0, x1, y1 in np.hstack([low, high]).tolist())


def outline_points(obj: SceneObject) -> FloatArray:
    """Points (n, 2) in metres along an object's outline, dense enough for its box."""
    points: list[tuple[float, float]] = []
    for record in obj.records:
        if isinstance(record, PointRecord):
            points.append(record.at)
            continue
        for edge in record_edges(record):
            if isinstance(edge, Arc):
                begin, sweep = edge.sweep(y_down=False)
                angles = begin + sweep * np.linspace(0.0, 1.0, _POINTS_AN_ARC)
                xs = edge.center[0] + edge.radius * np.cos(angles)
                ys = edge.center[1] + edge.radius * np.sin(angles)
            else:
                xs = np.linspace(edge.start[0], edge.end[0], _POINTS_A_LINE)
                ys = np.linspace(edge.start[1], edge.end[1], _POINTS_A_LINE)
            points += zip(xs.tolist(), ys.tolist(), strict=True)
    return np.array(points, dtype=np.float64).reshape(-1, 2)


def _parts(
    rectangles: Sequence[Rectangle], boxes: Sequence[_Box], size: tuple[int, int]
) -> list[_Box]:
    """Disjoint boxes that hold every rectangle and cut no object's box."""
    margin = _MARGIN_PX
    waiting = [_grown((x, y, x + w, y + h), margin, size) for x, y, w, h in rectangles]
    around = [_grown(box, _OBJECT_MARGIN_PX, size) for box in boxes]
    done: list[_Box] = []
    while waiting:
        part = waiting.pop()
        before: _Box | None = None
        while part != before:
            before = part
            for box in around:
                part = _union(part, box) if _meet(part, box) else part
        touched = [other for other in done if _meet(part, other)]
        if touched:
            done = [other for other in done if other not in touched]
            for other in touched:
                part = _union(part, other)
            waiting.append(part)
        else:
            done.append(part)
    return done


def _leaves(box: _Box, part: _Box, size: tuple[int, int]) -> bool:
    width, height = size
    return (
        (box[0] <= part[0] and part[0] > 0)
        or (box[1] <= part[1] and part[1] > 0)
        or (box[2] >= part[2] and part[2] < width)
        or (box[3] >= part[3] and part[3] < height)
    )


def _grown(box: _Box, margin: int, size: tuple[int, int]) -> _Box:
    return (
        max(0, box[0] - margin),
        max(0, box[1] - margin),
        min(size[0], box[2] + margin),
        min(size[1], box[3] + margin),
    )


def _union(a: _Box, b: _Box) -> _Box:
    return min(a[0], b[0]), min(a[1], b[1]), max(a[2], b[2]), max(a[3], b[3])


def _meet(a: _Box, b: _Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
