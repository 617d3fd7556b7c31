"""The commands `extract` and `plan`, asked in this process, and their answers as strict JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NoReturn

import cv2
import numpy as np

from tests.support.pictures import FREE, SOLID, blank, call

STAGES = (
    *("load", "binarise", "contours", "geometry", "voronoi", "roadmap", "path", "trajectory"),
    "total",
)
COUNTS = (
    *("border_pixels", "vertices", "generators", "voronoi_vertices", "roadmap_nodes"),
    "roadmap_edges",
)
RADIUS = 9.0
STEP = 0.25


def _no_constant(word: str) -> NoReturn:
    raise AssertionError(f"{word} is not JSON")


def strict(text: str) -> Any:
    """Parse JSON that holds no NaN and no infinity, and ends in one line feed."""
    assert text.endswith("}\n")
    return json.loads(text, parse_constant=_no_constant)


def extract(file: Path, *options: object) -> Any:
    told = call("extract", file, "--format", "json", *options)
    assert (told.code, told.err) == (0, "")
    return strict(told.out)


def plan(file: Path, start: str, goal: str, *options: object, radius: float = RADIUS) -> Any:
    told = call(
        *("plan", file, "--start", start, "--goal", goal, "--radius", radius),
        *("--format", "json", *options),
    )
    answer = strict(told.out)
    assert told.code == (0 if answer["status"] == "ok" else 3)
    return answer


def zoo() -> Any:
    """A rectangle with a round hole, a D (arc and chord), an L, a triangle and a single pixel."""
    picture = blank()
    cv2.rectangle(picture, (40, 40), (200, 180), SOLID, -1)
    cv2.circle(picture, (120, 110), 40, FREE, -1)
    y, x = np.ogrid[:480, :640]
    picture[((x - 420) ** 2 + (y - 110) ** 2 <= 70**2) & (x >= 420)] = SOLID
    picture[280:440, 60:91] = SOLID
    picture[410:440, 60:200] = SOLID
    cv2.fillPoly(picture, [np.array([[300, 420], [420, 400], [340, 280]])], SOLID)
    picture[300, 560] = SOLID
    return picture
