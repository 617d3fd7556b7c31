"""Cameras and eye of a simulated world, with drawn pictures or the truth. Metres, pixels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

import numpy as np

from navigation.config import Config
from navigation.config.several.each_camera import each_camera
from navigation.loop.seeing.vision_stage import EyeParts
from navigation.run.calibrations import calibration_of
from navigation.run.without_pictures.sights import Sights, make_sight_camera
from navigation.run.without_pictures.true_eye import TrueEye, TrueJoinedEye
from navigation.run.without_pictures.true_tracker import TrueTracker
from navigation.simulator.arena import SimulatedArena
from navigation.simulator.picture.camera import make_camera
from navigation.simulator.picture.pinhole import pinhole_of
from navigation.simulator.picture.timed_camera import TimedCamera
from planner.scene import Bounds

MOST_OFF_M: Final = 0.002
"""A calibration farther off moves the arena's outlines, which the truth does not contain."""


@dataclass(frozen=True, slots=True)
class Looking:
    """Constructors of cameras and parts of the eye; drawn pictures by default."""

    make_camera: Callable[..., TimedCamera[Any]] = make_camera
    parts: EyeParts = field(default_factory=EyeParts)


def looking_of(
    config: Config, arenas: Sequence[tuple[float, SimulatedArena]], *, pictures: bool
) -> Looking:
    """Return the parts for a run; ``ValueError`` for what would need pictures and has none."""
    if pictures:
        return Looking()
    for name, one in (each_camera(config) or {"": config}).items():
        why = _why_pictures(one)
        if why:
            camera = f"camera {name}: " if name else ""
            raise ValueError(f"a run without pictures: {camera}{why}; draw pictures for this run")
    if _empties(arenas) and config.safety.camera_moved_px > 0.0:
        raise ValueError(
            "a run without pictures: simulation.obstacles takes away more than half of what the "
            "arena began with, by which pictures tell that the camera stays where it is; draw "
            "pictures for this run"
        )
    sights = Sights()
    return Looking(
        partial(make_sight_camera, sights),
        EyeParts(
            partial(TrueTracker, sights=sights),
            partial(TrueEye, sights=sights),
            partial(TrueJoinedEye, sights=sights),
            watches_place=False,
        ),
    )


def _why_pictures(config: Config) -> str:
    """Reason why a camera needs pictures, if any."""
    assert config.simulation is not None
    if config.simulation.camera.knocks:
        return "simulation.camera.knocks: only a picture shows that a camera was knocked"
    if config.arena.floor_markers:
        return "arena.floor_markers: only a picture shows them"
    off_m = _calibration_off_m(config)
    if not off_m <= MOST_OFF_M:
        return (
            f"its calibration is off by up to {1e3 * off_m:.1f} mm, the limit is "
            f"{1e3 * MOST_OFF_M:g}: only a picture shows what comes of that"
        )
    return ""


def _calibration_off_m(config: Config) -> float:
    """Largest error of the calibration where the camera shows the arena."""
    pinhole, calibration = pinhole_of(config), calibration_of(config)
    bounds = Bounds(*config.arena.bounds_m)
    x, y = np.meshgrid(
        np.linspace(bounds.x_min, bounds.x_max, 12), np.linspace(bounds.y_min, bounds.y_max, 12)
    )
    places = np.column_stack([x.ravel(), y.ravel()])
    pixels = pinhole.image_from_arena(places)
    inside = ((pixels >= 0.0) & (pixels <= np.array(pinhole.size_px) - 1.0)).all(axis=1)
    seen = calibration.arena_from_image(pixels[inside])
    off = np.hypot(*(seen - places[inside]).T)
    off = off[np.isfinite(off)]
    return float(off.max(initial=0.0))


def _empties(arenas: Sequence[tuple[float, SimulatedArena]]) -> bool:
    first = {one.records for one in arenas[0][1].scene.objects}
    return any(
        2 * len(first & {one.records for one in arena.scene.objects}) < len(first)
        for _, arena in arenas
    )
