"""Several threads at once get what one alone gets, and nobody's input is changed."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import cv2
import numpy as np
import pytest

import planner
import vision
from planner.formats.scene_io import write_scene_text
from planner.path import Path as PlannedPath
from tests.support.drawn.boards import marker_patch, render
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame
from vision.markers.markers import MarkedRobot, MarkerTracker

THREADS, ROUNDS = 4, 6


@pytest.fixture(autouse=True)
def hasty_switches() -> Iterator[None]:
    """Threads take turns every ten microseconds, so that what they share is met half done."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(before)


def all_agree(work: Callable[[int], Any], kinds: int) -> None:
    """``work`` of a kind gives in a crowd of threads what it gives alone."""
    alone = [work(kind) for kind in range(kinds)]
    jobs = [i % kinds for i in range(THREADS * ROUNDS)]
    with ThreadPoolExecutor(THREADS) as pool:
        for kind, answer in zip(jobs, pool.map(work, jobs), strict=True):
            assert answer == alone[kind]


def arena(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    picture = np.full((240, 320), 215, np.uint8)
    for _ in range(7):
        x, y = (int(v) for v in rng.integers(20, (300, 220)))
        if rng.random() < 0.5:
            cv2.circle(picture, (x, y), int(rng.integers(8, 20)), 40, -1, cv2.LINE_AA)
        else:
            box = cv2.boxPoints(
                ((x, y), rng.uniform(15, 45, 2).tolist(), float(rng.uniform(0, 90)))
            )
            cv2.fillPoly(picture, [np.round(box).astype(np.int32)], 40, cv2.LINE_AA)
    noisy = cv2.GaussianBlur(picture, (0, 0), 0.7) + rng.normal(0, 3, picture.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)


PICTURES = [arena(seed) for seed in range(3)]
LENS = Calibration.from_camera(
    (320, 240),
    [[400.0, 0.0, 160.0], [0.0, 400.0, 120.0], [0.0, 0.0, 1.0]],
    [-0.1, 0.02, 0.0, 0.0, 0.0],
    [[1.0, 0.0, 0.0, -0.8], [0.0, -1.0, 0.0, 0.6], [0.0, 0.0, -1.0, 2.0]],
)


def records_of(scene: planner.Scene) -> str:
    """A scene's text without what its clock measured."""
    lines = write_scene_text(scene).splitlines()
    return "\n".join(line for line in lines if "timings_ms" not in line)


def test_extraction() -> None:
    def work(kind: int) -> str:
        image = PICTURES[kind % 3]
        if kind < 3:
            return records_of(vision.extract(image))
        if kind < 6:
            return records_of(vision.extract(image, calibration=LENS))
        return records_of(vision.extract(image, mode="paper"))

    kept = [p.copy() for p in PICTURES]
    for picture in PICTURES:
        picture.setflags(write=False)
    all_agree(work, 9)
    assert all(np.array_equal(a, b) for a, b in zip(kept, PICTURES, strict=True))


def test_voronoi() -> None:
    sites = [np.random.default_rng(seed).uniform(0, 100, (400, 2)) for seed in range(4)]
    kept = [s.copy() for s in sites]
    for s in sites:
        s.setflags(write=False)

    def work(kind: int) -> bytes:
        diagram = planner.voronoi(sites[kind])
        return np.ascontiguousarray(diagram.neighbours()).tobytes()

    all_agree(work, 4)
    assert all(np.array_equal(a, b) for a, b in zip(kept, sites, strict=True))


def test_roadmaps_and_plans_on_shared_and_own_ones() -> None:
    scenes = [vision.extract(p) for p in PICTURES]
    texts = [records_of(s) for s in scenes]
    shared = [planner.build_roadmap(s, radius=5.0) for s in scenes]

    def answer(roadmap: planner.Roadmap, kind: int) -> object:
        start, goal = (8.0, 8.0), ((310.0, 230.0), (10.0, 230.0))[kind % 2]
        path = roadmap.plan(start=start, goal=goal)
        if isinstance(path, PlannedPath):
            return (path.length, path.min_clearance, np.asarray(path.points).tobytes())
        return path.reason

    def work(kind: int) -> object:
        own = planner.build_roadmap(scenes[kind % 3], radius=5.0)
        graph = (own.graph.number_of_nodes(), own.graph.number_of_edges())
        return graph, answer(own, kind), answer(shared[kind % 3], kind)

    all_agree(work, 6)
    assert [records_of(s) for s in scenes] == texts


def test_trackers() -> None:
    patch = marker_patch(cv2.aruco.DICT_4X4_50, 3, 0.3, (0.8, 0.6, 0.5))
    image = render(LENS, [patch], noise=4.0, rng=np.random.default_rng(0))

    def work(kind: int) -> list[tuple[float, ...]]:
        tracker = MarkerTracker(LENS, [MarkedRobot(3, 0.3)])
        poses = []
        for i in range(4 + kind):
            poses += tracker.update(Frame(image, i / 30.0, i, "t"))
        assert poses
        return [(p.x, p.y, p.heading_rad, p.vx, p.vy) for p in poses]

    all_agree(work, 3)
