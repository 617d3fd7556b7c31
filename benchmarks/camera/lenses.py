"""Poses, outlines and undistorted points through lenses of all kinds, against rendered truth.

    python -m benchmarks.camera.lenses

Writes benchmarks/results/lenses.md. Pictures are ray-traced with OpenCV's inverse of the lens, not
with Clearway's; things lie at random places of the picture and are equally large in it, so that
lenses are compared at the same pixels. Errors are pixels of the raw picture.
"""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np

import vision
from planner.scene import Arc, Edge, record_edges
from tests.support.drawn.lens_pictures import (
    Array,
    LensCamera,
    disc_paint,
    marker_paint,
    picture,
    square_corners,
    square_paint,
    window_around,
)
from vision.markers.marker_pattern import pattern_bits
from vision.markers.reading import find_markers

ROOT = Path(__file__).parents[2]
RESULT = ROOT / "benchmarks" / "results" / "lenses.md"
SIZE = (1280, 960)
MARKER_PX, SHAPE_PX = 48.0, 60.0
THINGS = 6
PICTURES = 12
MOST_ANGLE_DEG = 70.0
BANDS = (1.0, 1.3, 1.7, 2.2, 3.2)
"""Of flatness: how many times as long as wide the picture shows a disc on the floor."""
PINHOLES = 2
"""So many cameras come first that the others are compared with, at the same flatness."""
BOOK = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)


def pose(tilt: tuple[float, float, float], center: tuple[float, float, float]) -> Array:
    """Arena to camera, (3, 4), of a camera that looks down, turned a little."""
    rotation = cv2.Rodrigues(np.array(tilt))[0] @ np.diag([1.0, -1.0, -1.0])
    return np.column_stack([rotation, -rotation @ np.array(center)])


def cameras() -> tuple[LensCamera, ...]:
    """Pinholes, straight down and tilted, Brown's lens, and fisheyes of 180 degrees."""
    above = pose((0.03, 0.05, 0.2), (1.2, 0.9, 1.5))
    matrix = np.array([[800.0, 0.0, 645.0], [0.0, 802.0, 476.0], [0.0, 0.0, 1.0]])
    wide = np.array([[330.0, 0.0, 645.0], [0.0, 331.0, 476.0], [0.0, 0.0, 1.0]])
    return (
        LensCamera("pinhole", SIZE, matrix, "brown", np.zeros(5), above),
        LensCamera(
            "pinhole, tilted", SIZE, matrix, "brown", np.zeros(5),
            pose((0.75, 0.0, 0.0), (1.2, -0.6, 1.5)),
        ),
        LensCamera(
            "Brown", SIZE, matrix, "brown", np.array([-0.25, 0.07, 1e-3, -8e-4, 0.01]), above
        ),
        LensCamera("fisheye, equidistant", SIZE, wide, "fisheye", np.zeros(4), above),
        LensCamera(
            "fisheye, four terms", SIZE, wide, "fisheye",
            np.array([-0.04, 0.012, -0.006, 0.001]), above,
        ),
    )  # fmt: skip


def spots(camera: LensCamera, size_px: float, rng: np.random.Generator) -> Array:
    """Pixels (n, 2) all over the picture, apart, where the floor is seen within 70 degrees."""
    found: list[Array] = []
    rim = 1.2 * size_px
    while len(found) < THINGS:
        pixel = rng.uniform((rim, rim), np.array(SIZE) - rim)
        near = any(np.linalg.norm(pixel - other) < 3.0 * size_px for other in found)
        if not near and angle_deg(camera, pixel) < MOST_ANGLE_DEG:
            found.append(pixel)
    return np.array(found)


def angle_deg(camera: LensCamera, pixel: Array) -> float:
    """Between the ray of a pixel and the floor's normal: how flat the floor is seen."""
    ray = np.array([*camera.rays(pixel[None])[0], 1.0])
    return math.degrees(math.acos(-float(camera.pose[:, 2] @ ray) / float(np.linalg.norm(ray))))


def flatness(camera: LensCamera, pixel: Array) -> float:
    """How many times as long as wide a small disc on the floor is at a pixel of the picture.

    A fisheye shows floor flatter than a pinhole does at the same angle: what is compared has the
    same shape in the picture, and so as many pixels along and across.
    """
    place = camera.places(pixel[None])[0]
    step = 1e-4 * camera.metres_at(pixel)
    beside = camera.pixels(
        place + step * np.array([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
    )
    longest, shortest = np.linalg.svd(beside[::2] - beside[1::2], compute_uv=False)
    return float(longest / shortest)


def poses(camera: LensCamera, seed: int = 1, pictures: int = PICTURES) -> tuple[Array, int]:
    """Rows (n, 3) of angle, error and flatness of markers' centres; how many were not found."""
    rng = np.random.default_rng(seed)
    calibration = camera.calibration()
    rows, lost = [], 0
    for _ in range(pictures):
        truth, painted = {}, []
        for marker_id, pixel in enumerate(spots(camera, MARKER_PX, rng)):
            place = camera.places(pixel[None])[0]
            side_m = MARKER_PX * camera.metres_at(pixel)
            heading = rng.uniform(-math.pi, math.pi)
            bits = pattern_bits(BOOK, marker_id)
            rim = camera.pixels(square_corners(place, 1.4 * side_m, heading))
            paint = marker_paint(bits, side_m, (*place, heading))
            painted.append((paint, window_around(rim, SIZE)))
            truth[marker_id] = place
        image = picture(camera, painted, rng)
        found = {
            m.id: m for m in find_markers(image, dictionary="DICT_4X4_50", calibration=calibration)
        }
        for marker_id, place in truth.items():
            marker = found.get(marker_id)
            if marker is None or marker.pose is None or marker.remark:
                lost += 1
                continue
            seen, wanted = camera.pixels(np.array([marker.pose[:2], place]))
            off_px = float(np.linalg.norm(seen - wanted))
            rows.append((angle_deg(camera, wanted), off_px, flatness(camera, wanted)))
    return np.array(rows), lost


def outlines(camera: LensCamera, seed: int = 2, pictures: int = PICTURES) -> tuple[Array, int]:
    """Rows (n, 3) of angle, rms and flatness of outlines; how many have too many edges."""
    rng = np.random.default_rng(seed)
    calibration = camera.calibration()
    rows, split = [], 0
    for _ in range(pictures):
        shapes, painted = [], []
        for number, pixel in enumerate(spots(camera, SHAPE_PX, rng)):
            place = camera.places(pixel[None])[0]
            size_m = SHAPE_PX * camera.metres_at(pixel)
            heading = rng.uniform(-math.pi, math.pi)
            corners = square_corners(place, size_m, heading)
            if number % 2:
                paint, border = square_paint(place, size_m, heading), dense(corners)
            else:
                turns = np.linspace(0.0, math.tau, 2000, endpoint=False)
                ring = np.column_stack([np.cos(turns), np.sin(turns)])
                border = place + 0.5 * size_m * ring
                paint = disc_paint(place, 0.5 * size_m)
            seen = camera.pixels(border)
            painted.append((paint, window_around(seen, SIZE)))
            shapes.append((place, seen, 4 if number % 2 else 2, size_m))
        scene = vision.extract(
            picture(camera, painted, rng), calibration=calibration, bounds=(-9.0, -9.0, 11.0, 11.0)
        )
        for place, seen, edges_needed, size_m in shapes:
            best = None
            for thing in scene.objects:
                edges = [e for r in thing.records for e in record_edges(r)]
                points = np.concatenate([along(edge, size_m / 100.0) for edge in edges])
                if np.linalg.norm(points.mean(axis=0) - place) < 0.3 * size_m:
                    best = (points, len(edges))
            if best is None:
                split += 1
                continue
            off = distances(camera.pixels(best[0]), seen)
            middle = camera.pixels(place[None])[0]
            off_px = float(np.sqrt((off**2).mean()))
            rows.append((angle_deg(camera, middle), off_px, flatness(camera, middle)))
            split += best[1] > edges_needed
    return np.array(rows), split


def dense(corners: Array) -> Array:
    """Points along a closed polygon."""
    share = np.linspace(0.0, 1.0, 500, endpoint=False)[:, None]
    return np.concatenate(
        [
            a * (1.0 - share) + b * share
            for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)
        ]
    )


def along(edge: Edge, step_m: float) -> Array:
    """Points along a fitted edge, about ``step_m`` apart: a short edge counts as what it is."""
    length_m = math.dist(edge.start, edge.end)
    if isinstance(edge, Arc):
        length_m = edge.radius * abs(edge.sweep(y_down=False)[1])
    share = np.linspace(0.02, 0.98, max(2, round(length_m / step_m)))[:, None]
    if isinstance(edge, Arc):
        begin, sweep = edge.sweep(y_down=False)
        turns = (begin + sweep * share).ravel()
        ring = np.column_stack([np.cos(turns), np.sin(turns)])
        return np.asarray(np.array(edge.center) + edge.radius * ring)
    return np.asarray(np.array(edge.start) * (1.0 - share) + np.array(edge.end) * share)


def distances(points: Array, border: Array) -> Array:
    """From each point to the nearest chord of a closed, dense border."""
    ends = np.roll(border, -1, axis=0)
    steps = ends - border
    lengths = np.maximum((steps**2).sum(axis=1), 1e-18)
    least = []
    for point in points:
        share = np.clip(((point - border) * steps).sum(axis=1) / lengths, 0.0, 1.0)
        least.append(np.hypot(*(border + steps * share[:, None] - point).T).min())
    return np.array(least)


def undistorted(camera: LensCamera, count: int = 20_000) -> float:
    """The largest error of ``undistort_points``, seen through OpenCV's projection, raw pixels."""
    pixels = np.random.default_rng(3).uniform((0, 0), SIZE, (count, 2))
    ideal = camera.calibration().undistort_points(pixels)
    seen = np.isfinite(ideal[:, 0])
    k = camera.matrix
    rays = (ideal[seen] - k[:2, 2]) / np.array([k[0, 0], k[1, 1]])
    return float(np.abs(camera._bent(rays) - pixels[seen]).max())


def rms(errors: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt((errors**2).mean()))


def in_band(rows: Array, low: float, high: float) -> Array:
    """The errors at a flatness in between."""
    return np.asarray(rows[(rows[:, 2] >= low) & (rows[:, 2] < high), 1])


def bands_of(name: str, rows: tuple[Array, Array], pinholes: tuple[Array, Array]) -> list[str]:
    """Lines of a table: errors and their ratios to the pinholes', by flatness."""
    lines = []
    for low, high in pairwise(BANDS):
        cells = []
        for mine, theirs in zip(rows, pinholes, strict=True):
            here, there = in_band(mine, low, high), in_band(theirs, low, high)
            enough = min(len(here), len(there)) >= 5
            cells.append(f"{rms(here):.4f} | {rms(here) / rms(there):.2f}" if enough else "- | -")
        lines.append(f"| {name} | {low:g} to {high:g} | {' | '.join(cells)} |")
    return lines


def main() -> None:
    """Measure all, and write the page."""
    table, bands = [], []
    measured: list[tuple[Array, Array]] = []
    for number, camera in enumerate(cameras()):
        (marked, lost), (outlined, split) = poses(camera), outlines(camera)
        measured.append((marked, outlined))
        table.append(
            f"| {camera.name} | {rms(marked[:, 1]):.4f} | {rms(outlined[:, 1]):.4f} "
            f"| {undistorted(camera):.0e} | {lost} of {len(marked) + lost} | {split} |"
        )
        print(table[-1], flush=True)
        if number >= PINHOLES:
            first, second = zip(*measured[:PINHOLES], strict=True)
            pooled = np.concatenate(first), np.concatenate(second)
            bands += bands_of(camera.name, measured[-1], pooled)
            print("\n".join(bands[1 - len(BANDS) :]), flush=True)
    lines = [
        "# Lenses",
        "",
        "Made by `python -m benchmarks.camera.lenses`.",
        "",
        f"Markers of {MARKER_PX:g} px and shapes of {SHAPE_PX:g} px (roots of areas) all over",
        "the raw picture, 1280x960, blur 0.7 px, noise 2 grey; rms in raw pixels. Fisheyes",
        f"show 180 degrees; all lie within {MOST_ANGLE_DEG:g} degrees of the floor's normal. Lost:",
        "markers that were not read; split: outlines of too many edges. Target: 0.05 px.",
        "",
        "| lens | poses px | outlines px | undistort px | lost | split |",
        "|---|---|---|---|---|---|",
        *table,
        "",
        "By how many times as long as wide a disc on the floor is in the picture there; ratios to",
        "the pinholes at the same. Target: 1.1.",
        "",
        "| lens | flatness | poses px | ratio | outlines px | ratio |",
        "|---|---|---|---|---|---|",
        *bands,
    ]
    RESULT.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
