"""Compile every kernel before the robot may move: a first compilation takes seconds.

A tiny scene goes through the whole chain once. Loaded from the kernel cache this takes well
under a second; the first time on a machine it takes some seconds.
"""

from __future__ import annotations

import numpy as np

import planner
import vision
from planner.path import Path
from planner.trajectory import default_limits


def warm_up(size_px: tuple[int, int]) -> None:
    """Run extractor, roadmap, plan and timing once on a picture of this (width, height)."""
    width, height = size_px
    picture = np.full((height, width), 230, np.uint8)
    middle = picture[height // 3 : height // 2, width // 3 : width // 2]
    middle[:] = 25
    picture[height // 4, width // 4 :: 3] = 25
    scene = vision.extract(picture)
    radius = height / 50.0
    roadmap = planner.build_roadmap(scene, radius)
    corner = (3.0 * radius, 3.0 * radius)
    far = (width - 3.0 * radius, height - 3.0 * radius)
    path = roadmap.plan(corner, far)
    if isinstance(path, Path):
        planner.time_path(path, default_limits(radius), clearance=roadmap.clearance)
