"""Marker poses against the truth of rendered pictures, beside OpenCV's own refinements.

    python -m benchmarks.markers [--count 200]

Writes benchmarks/results/markers.md: for each side of marker and noise the rms error of centre
and heading and how many were found, the same for every dictionary, and the time of a tracker's
frame at 1920x1080.
"""

from __future__ import annotations

import argparse
import math
import time
from collections import defaultdict
from collections.abc import Callable
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tests.support.drawn.boards import marker_patch, pose_bound, render
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame
from vision.markers.marker_search import dictionary_by_name, dictionary_names
from vision.markers.markers import MarkedRobot, MarkerTracker
from vision.markers.tracking import TrackLimits

RESULT = Path(__file__).parent / "results" / "markers.md"
SEED = 20240501
DICTIONARY = cv2.aruco.DICT_4X4_50
BOUNDED = 20
"""So many markers of each size give the Cramer-Rao bound's rms."""
SIDES_PX = (30, 45, 60, 90)
NOISES = (0.0, 5.0, 10.0, 20.0)
PEERS = {
    "cv2 none": cv2.aruco.CORNER_REFINE_NONE,
    "cv2 subpix": cv2.aruco.CORNER_REFINE_SUBPIX,
    "cv2 contour": cv2.aruco.CORNER_REFINE_CONTOUR,
    "cv2 apriltag": cv2.aruco.CORNER_REFINE_APRILTAG,
}
UNIT = np.array([-0.5 + 0.5j, 0.5 + 0.5j, 0.5 - 0.5j, -0.5 - 0.5j])


def camera() -> Calibration:
    """A tilted camera with a lens, 2 m above the floor, about 2 mm a pixel."""
    turn = cv2.Rodrigues(np.array([0.06, -0.04, 0.03]))[0] @ np.diag([1.0, -1.0, -1.0])
    pose = np.column_stack([turn, -turn @ np.array([0.3, 0.3, 2.0])])
    matrix = [[1000.0, 0.0, 158.0], [0.0, 1002.0, 162.0], [0.0, 0.0, 1.0]]
    return Calibration.from_camera((320, 320), matrix, [-0.25, 0.08, 0.001, -0.001, 0.0], pose)


def error(
    quad: NDArray[np.float64], truth: tuple[float, float, float], calibration: Calibration
) -> tuple[float, float]:
    """(centre error in pixels, heading error in degrees) of four raw corners."""
    corners = calibration.arena_from_image(quad)
    points = corners[:, 0] + 1j * corners[:, 1]
    center = points.mean()
    heading = float(np.angle(np.vdot(UNIT, points - center)))
    off = abs(center - complex(truth[0], truth[1])) / calibration.metres_per_pixel
    return float(off), math.degrees(math.remainder(heading - truth[2], math.tau))


def ours(
    image: NDArray[np.uint8],
    robot: MarkedRobot,
    calibration: Calibration,
    dictionary: str = "DICT_4X4_50",
) -> NDArray[np.float64] | None:
    """The corners that a tracker which knows nothing yet finds, in the first frame or the next."""
    tracker = MarkerTracker(calibration, [robot], dictionary)
    for i in range(2):
        poses = tracker.update(Frame(image, i / 30.0, i, "bench"))
        if poses:
            return poses[0].corners_px
    return None


def detectors() -> dict[str, cv2.aruco.ArucoDetector]:
    book = cv2.aruco.getPredefinedDictionary(DICTIONARY)
    made = {}
    for name, method in PEERS.items():
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = method
        made[name] = cv2.aruco.ArucoDetector(book, parameters)
    return made


def accuracy(count: int) -> list[str]:
    rng = np.random.default_rng(SEED)
    calibration, peers = camera(), detectors()
    rows = []
    for side_px in SIDES_PX:
        errors: dict[tuple[float, str], list[tuple[float, float]]] = defaultdict(list)
        least = []
        size_m = side_px * calibration.metres_per_pixel
        for number in range(count):
            marker_id, heading = int(rng.integers(50)), float(rng.uniform(-math.pi, math.pi))
            middle = rng.uniform(110.0, 210.0, 2)
            x, y = calibration.arena_from_image([middle])[0]
            truth = (float(x), float(y), heading)
            half = min(100, round(1.1 * side_px) + 6)
            window = (round(middle[0]) - half, round(middle[1]) - half, 2 * half, 2 * half)
            patch = marker_patch(DICTIONARY, marker_id, size_m, truth)
            clean = render(calibration, [patch], window=window)
            if number < BOUNDED:
                least.append(pose_bound(calibration, patch, 1.0, window))
            robot = MarkedRobot(marker_id, size_m, limits=TrackLimits(confirm=1))
            for noise in NOISES:
                noisy = clean + rng.normal(0.0, noise, clean.shape)
                image = np.clip(np.round(noisy), 0, 255).astype(np.uint8)
                corners = ours(image, robot, calibration)
                if corners is not None:
                    errors[noise, "clearway"].append(error(corners, truth, calibration))
                for name, quad in measured(image, marker_id, peers):
                    errors[noise, name].append(error(quad, truth, calibration))
        bound = np.sqrt(np.mean(np.square(least), axis=0))
        for noise in NOISES:
            off, turned = noise * bound
            rows.append(f"| {side_px} | {noise:g} | bound | {off:.4f} | {turned:.4f} | |")
            for name in ("clearway", *PEERS):
                got = np.array(errors[noise, name]).reshape(-1, 2)
                off, turned = np.sqrt(np.mean(got**2, axis=0)) if len(got) else (np.nan, np.nan)
                rows.append(
                    f"| {side_px} | {noise:g} | {name} | {off:.4f} | {turned:.4f} "
                    f"| {len(got)} of {count} |"
                )
                print(rows[-1], flush=True)
    return rows


def measured(
    image: NDArray[np.uint8], marker_id: int, peers: dict[str, cv2.aruco.ArucoDetector]
) -> list[tuple[str, NDArray[np.float64]]]:
    """The corners that each of OpenCV's methods gives, where it finds the marker."""
    found = []
    for name, detector in peers.items():
        corners, ids, _ = detector.detectMarkers(image)
        if ids is None or marker_id not in np.ravel(ids):
            continue
        index = int(np.flatnonzero(np.ravel(ids) == marker_id)[0])
        quad = np.asarray(corners[index], dtype=np.float64).reshape(4, 2)
        found.append((name, quad))
    return found


def dictionaries(count: int) -> list[str]:
    """Every dictionary of OpenCV: markers of 45 px at noise 5, the rms errors, how many found."""
    calibration = camera()
    size_m = 45 * calibration.metres_per_pixel
    rows = []
    for name in dictionary_names():
        rng = np.random.default_rng(SEED)
        number = getattr(cv2.aruco, name)
        ids = len(dictionary_by_name(name).bytesList)
        got = []
        for _ in range(count):
            marker_id, heading = int(rng.integers(ids)), float(rng.uniform(-math.pi, math.pi))
            middle = rng.uniform(110.0, 210.0, 2)
            x, y = calibration.arena_from_image([middle])[0]
            truth = (float(x), float(y), heading)
            window = (round(middle[0]) - 55, round(middle[1]) - 55, 110, 110)
            patch = marker_patch(number, marker_id, size_m, truth)
            noisy = render(calibration, [patch], window=window) + rng.normal(0.0, 5.0, (320, 320))
            image = np.clip(np.round(noisy), 0, 255).astype(np.uint8)
            robot = MarkedRobot(marker_id, size_m, limits=TrackLimits(confirm=1))
            corners = ours(image, robot, calibration, name)
            if corners is not None:
                got.append(error(corners, truth, calibration))
        off, turned = np.sqrt(np.mean(np.square(got), axis=0)) if got else (np.nan, np.nan)
        rows.append(f"| {name} | {ids} | {off:.4f} | {turned:.4f} | {len(got)} of {count} |")
        print(rows[-1], flush=True)
    return rows


def speed(frames: int = 60) -> list[str]:
    """Milliseconds a frame of 1920x1080 with one robot of 60 px: followed, and searched for."""
    rng = np.random.default_rng(SEED)
    calibration = Calibration.from_scale(0.002, (1920, 1080))
    robot = MarkedRobot(7, 0.12)
    window = (900, 480, 160, 160)
    place = calibration.arena_from_image([(980.0, 560.0)])[0]
    patch = marker_patch(DICTIONARY, 7, 0.12, (float(place[0]), float(place[1]), 0.4))
    clean = render(calibration, [patch], window=window)
    cv2.rectangle(clean, (200, 200), (500, 330), 40, -1)
    cv2.circle(clean, (1500, 800), 120, 40, -1)
    images = [
        np.clip(clean + rng.normal(0.0, 5.0, clean.shape), 0, 255).astype(np.uint8)
        for _ in range(4)
    ]
    followed, searched, whole = [], [], []
    tracker = MarkerTracker(calibration, [robot])
    for i in range(frames):
        frame = Frame(images[i % 4], i / 30.0, i, "bench")
        took = timed_ms(partial(tracker.update, frame))
        if i > 3:
            followed.append(took)
        fresh = MarkerTracker(calibration, [robot])
        searched.append(timed_ms(partial(fresh.update, frame)))
    plain = detectors()["cv2 subpix"]
    for image in images * 3:
        whole.append(timed_ms(partial(plain.detectMarkers, image)))
    rows = []
    for name, times in (
        ("followed: looked for where it should be", followed),
        ("lost: the whole picture searched", searched),
        ("cv2.aruco.ArucoDetector with its defaults and subpix", whole),
    ):
        wall, processor = np.array(times).T
        rows.append(
            f"| {name} | {np.median(wall):.1f} | {wall.min():.1f} | {np.median(processor):.1f} |"
        )
    return rows


def timed_ms(call: Callable[[], object]) -> tuple[float, float]:
    """(wall, processor) milliseconds of a call, the processor's over all threads."""
    began_s, worked_s = time.perf_counter(), time.process_time()
    call()
    return 1000.0 * (time.perf_counter() - began_s), 1000.0 * (time.process_time() - worked_s)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200, help="markers a cell")
    count = parser.parse_args().count
    rows, books, times = accuracy(count), dictionaries(max(1, count // 10)), speed()
    print("\n".join(times))
    text = [
        "# Marker poses",
        "",
        f"{count} rendered markers a side, DICT_4X4_50, a tilted camera with a lens, seed {SEED}, "
        f"OpenCV {cv2.__version__}.",
        "Each method's corners go through the same homography. Targets: 0.05 px and 0.1 degrees",
        "at sides of 30 to 90 px. cv2's AprilTag corners follow another pixel convention.",
        "`clearway` is a tracker that begins, with one or two looks at the picture. `bound` is the",
        f"Cramer-Rao bound, the least error that any unbiased estimate can have, of {BOUNDED} of "
        "the markers.",
        "",
        "| side px | noise | method | centre rms px | heading rms deg | found |",
        "|---|---|---|---|---|---|",
        *rows,
        "",
        "Every dictionary of OpenCV, markers of 45 px at noise 5, found by a tracker that begins:",
        "",
        "| dictionary | markers | centre rms px | heading rms deg | found |",
        "|---|---|---|---|---|",
        *books,
        "",
        "One robot of 60 px in 1920x1080 at noise 5, milliseconds a frame:",
        "",
        "| what | median | least | median of processor time |",
        "|---|---|---|---|",
        *times,
    ]
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text("\n".join(text) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
