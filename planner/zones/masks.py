"""Zones from Nav2's filter masks, masks of zones, and masks as text, for files that keep them."""

from __future__ import annotations

import os
from collections.abc import Sequence

from planner.formats.mask_files import SpeedLevel, save_mask
from planner.formats.scene_text import read_scene_text, write_scene_text
from planner.scene import Scene, SceneError, derived_bounds, extent_points
from planner.zones.areas import MaskArea
from planner.zones.zone import Zone
from planner.zones.zoned_roadmap import with_objects


def speed_zones(
    levels: Sequence[SpeedLevel], name: str, *, robot_speed: float | None = None
) -> tuple[Zone, ...]:
    """Return a slow zone for each level of a speed mask, see :func:`planner.load_speed_mask`.

    They are called ``name`` with a number. Percent are of ``robot_speed`` > 0, in metres a second.
    Raises :class:`SceneError` for levels in percent without it.
    """
    zones = []
    for number, level in enumerate(levels, 1):
        speed = level.speed_m_s
        if speed is None:
            if robot_speed is None:
                raise SceneError(f"{name}: its limits are in percent: robot_speed must be given")
            speed = 0.01 * level.limit * robot_speed
        area = MaskArea(level.area.objects, name)
        zones.append(Zone(f"{name}-{number}", "slow", area, speed=speed))
    return tuple(zones)


def save_keepout_mask(
    zones: Sequence[Zone], scene: Scene, path: str | os.PathLike[str], resolution: float
) -> None:
    """Write the keep-out zones as a mask for Nav2 that covers the scene's bounds.

    Arguments and errors are those of :func:`planner.save_mask`.
    """
    save_mask(_areas(zones, scene, "keep_out"), path, resolution)


def save_speed_mask(
    zones: Sequence[Zone], scene: Scene, path: str | os.PathLike[str], resolution: float,
    *, base: float, multiplier: float,
) -> None:  # fmt: skip
    """Write all zones with a speed as a mask for Nav2, in metres a second.

    Arguments and errors are those of :func:`planner.save_mask`.
    """
    slow = [one for one in zones if one.speed is not None]
    levels = [
        SpeedLevel(_areas([one], scene, one.kind), speed_m_s=one.speed)
        for one in sorted(slow, key=lambda one: one.speed or 0.0)
    ]
    save_mask(levels, path, resolution, base=base, multiplier=multiplier)


def mask_text(area: MaskArea) -> str:
    """Write a mask as a scene text, without its source; it must have an object."""
    places = (place for one in area.objects for place in extent_points(one))
    return write_scene_text(Scene("m", derived_bounds(places), area.objects))


def mask_of_text(text: str, source: str) -> MaskArea:
    """Read an equal mask from a :func:`mask_text`; :class:`SceneError` for other text."""
    return MaskArea(read_scene_text(text, "kept mask").objects, source)


def _areas(zones: Sequence[Zone], scene: Scene, kind: str) -> Scene:
    outlines = [
        thing for one in zones if one.kind == kind for thing in one.area.outlines(y_down=False)
    ]
    return with_objects(Scene(scene.units, scene.bounds, ()), outlines)
