"""Everything that needs kernels, once on small examples, to be compiled ahead.

``python -m navigation.run.kernels.rehearsal`` compiles it all beside the sources. A run's warm-up
needs less.
"""

from __future__ import annotations

import sys
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import planner
import vision
from navigation.config import Config
from navigation.run.kernels.compiling import compile_parts
from navigation.run.kernels.warm_up import compile_eye, compile_planner, say_now_and_then
from planner.scene import Bounds, Scene
from vision.binarise import METHODS, POLARITIES
from vision.camera.camera import Image

SIZE_PX = (160, 120)
RADIUS_PX = 4.0
STATIONS = ((6.0, 6.0), (150.0, 110.0), (80.0, 8.0), (8.0, 110.0))
PLACES = ((0.0, 0.0), (20.0, 0.0), (10.0, 9.0))
EDGES = ((0, 1), (1, 0), (1, 2), (2, 1), (0, 2), (2, 0))
CONFIG = {
    "arena": {"bounds_m": [0.0, 0.0, 2.0, 1.5]},
    "camera": {"source": 0, "calibration": "none.yaml"},
    "robot": {"marker_id": 0, "marker_size_m": 0.1, "radius_m": 0.1},
    "serial": {"port": "/dev/ttyUSB0"},
}
"""Neither camera nor robot is opened here."""
SCENE = """L 4 (40,40) (60,40) (60,60) (40,60)
L 3 (110,20) (130,40) (105,45)
C (100,85) 12
S (20,80) (50,95)
A 3 (70,75) (75,65) (85,75)
P (140,90)
"""


def see_an_arena() -> None:
    """Do the work of a run's eye."""
    compile_eye(Config.model_validate(CONFIG))


def see_pictures() -> None:
    """Do that, and see a drawing, whose outlines separate its pixels: no run needs those."""
    see_an_arena()
    vision.extract(_drawing())


def rehearse_eye() -> None:
    """Run every way from a picture to a scene."""
    see_an_arena()
    rng = np.random.default_rng(0)
    drawn = _drawing()
    noisy = np.clip(cv2.GaussianBlur(drawn, (0, 0), 0.8) + rng.normal(0, 3, drawn.shape), 0, 255)
    grey = noisy.astype(np.uint8)
    shade = np.linspace(0.4, 1.0, SIZE_PX[0])
    pictures: list[NDArray[Any]] = [
        drawn,
        grey,
        (grey * shade).astype(np.uint8),
        cv2.cvtColor(drawn, cv2.COLOR_GRAY2BGR),
        _coloured(rng),
        grey.astype(np.uint16) * 200,
    ]
    for picture in pictures:
        for polarity in POLARITIES:
            vision.extract(picture, polarity=polarity)
        vision.extract(picture, mode="paper")
    for method in METHODS:
        vision.extract(grey, method=method, threshold=128 if method == "fixed" else None)
        vision.extract(drawn, method=method, threshold=128 if method == "fixed" else None)


def rehearse_planner() -> None:
    """Run every way from a scene to a path."""
    compile_planner()
    scene = planner.read_scene_text(SCENE)
    bare = Scene("px", Bounds(0.0, 0.0, *SIZE_PX), ())
    for one in (scene, bare):
        for mode in ("exact", "paper"):
            roadmap = planner.build_roadmap(one, RADIUS_PX, mode=mode)
            _ = roadmap.graph, roadmap.counts, roadmap.remarks
            roadmap.clearance(STATIONS)
            for prefer in ("clearance", "length", "balanced"):
                path = roadmap.plan(*STATIONS[:2], prefer=prefer, alternatives=2, margin=0.5)
                roadmap.plan(*STATIONS[:2], prefer=prefer, via=STATIONS[2:], order="best")
                if not isinstance(path, planner.NoPath):
                    roadmap.path_clearance(path.points)
        # too large for every path: the reason for having none
        planner.build_roadmap(one, 30.0).plan(*STATIONS[:2])
        planner.build_roadmap(one, RADIUS_PX).updated(scene)
    roadmap = planner.build_roadmap(scene, RADIUS_PX)
    planner.plan_fleet(roadmap, STATIONS[:2], STATIONS[2:])
    planner.plan_on_graph(PLACES, EDGES, 1.0, [0, 1], [1, 0])  # they exchange places
    planner.voronoi(np.random.default_rng(0).random((50, 2)))


def _drawing() -> Image:
    picture = np.full((SIZE_PX[1], SIZE_PX[0]), 255, np.uint8)
    cv2.fillPoly(picture, [np.array([(15, 15), (50, 20), (40, 50), (20, 45)])], 0)
    cv2.circle(picture, (100, 40), 25, 0, -1)
    cv2.circle(picture, (100, 40), 12, 255, -1)
    cv2.circle(picture, (40, 90), 14, 0, -1)
    cv2.ellipse(picture, (120, 90), (25, 15), 20.0, 0.0, 360.0, 0, -1)
    cv2.line(picture, (60, 105), (95, 85), 0, 1)
    picture[70, 70] = 0
    return picture


def _coloured(rng: np.random.Generator) -> Image:
    """Obstacles that differ from the floor in colour but not in grey."""
    picture = np.full((SIZE_PX[1], SIZE_PX[0], 3), (90, 140, 90), np.uint8)
    picture[30:60, 30:70] = (40, 60, 220)
    cv2.circle(picture, (110, 70), 20, (220, 60, 40), -1)
    noisy = picture + rng.normal(0.0, 2.0, picture.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)


def main() -> int:
    """Compile missing kernels beside the sources; return 1 if a part failed."""
    parts = {"eye": (rehearse_eye, ()), "planner": (rehearse_planner, ())}
    last = say_now_and_then(compile_parts(parts), print)
    return 1 if last.failed else 0


if __name__ == "__main__":
    sys.exit(main())
