"""The watch over a running arena, and calibration: what they cost and how right they are.

    python -m benchmarks.watching [--count 200]

Writes benchmarks/results/watching.md: milliseconds a frame beside OpenCV's background
subtractors in the same run, frames until a change is reported, false reports over noise and
a driving robot, the time of a scene brought up to date beside that of a whole extraction, and
the residuals of real and of rendered calibrations. Seeds are in the file.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

import vision
from planner.scene import Bounds
from vision.calibrate.board import BoardSpec, find_boards
from vision.calibrate.lens import Lens, estimate_lens
from vision.calibrate.survey import Survey, fit_arena
from vision.calibration.calibration import Calibration
from vision.camera.sources import read_picture
from vision.watch.change import SceneWatcher
from vision.watch.refit import KnownScene

RESULT = Path(__file__).parent / "results" / "watching.md"
SEED = 20240601
NOISES = (0.0, 5.0, 10.0, 20.0)
NOBODY = np.empty((0, 3))
Picture = NDArray[np.uint8]


def arena(size: tuple[int, int], rng: np.random.Generator, count: int = 12) -> Picture:
    """A light floor with dark boxes and discs."""
    width, height = size
    picture = np.full((height, width), 190, np.uint8)
    for i in range(count):
        x, y = rng.uniform((60, 60), (width - 60, height - 60))
        w, h = rng.uniform(20, 80, 2)
        box = cv2.boxPoints(((x, y), (w, h), float(rng.uniform(0, 90))))
        if i % 3:
            cv2.fillPoly(picture, [np.round(box).astype(np.int32)], 40, cv2.LINE_AA)
        else:
            cv2.circle(picture, (round(x), round(y)), round(0.4 * w), 40, -1, cv2.LINE_AA)
    return cv2.GaussianBlur(picture, (0, 0), 0.8).astype(np.uint8)


def noisy(picture: Picture, noise: float, rng: np.random.Generator) -> Picture:
    """White noise, cut at random out of a long row: drawing it anew takes ten times as long."""
    at = int(rng.integers(len(_WHITE) - picture.size))
    field = _WHITE[at : at + picture.size].reshape(picture.shape)
    return cv2.add(picture, field * np.float32(noise), dtype=cv2.CV_8U).astype(np.uint8, copy=False)


_WHITE = np.random.default_rng(SEED).standard_normal(32_000_000, dtype=np.float32)


def speed() -> list[str]:
    """Processor milliseconds a frame, interleaved, the median of 60."""
    rng = np.random.default_rng(SEED)
    rows = []
    body = np.array([[400.0, 600.0, 60.0]])
    for size in ((1280, 960), (1920, 1080)):
        floor = arena(size, rng)
        for colours in (1, 3):
            wide = floor if colours == 1 else np.repeat(floor[..., None], 3, axis=2)
            frames = [noisy(wide, 5.0, rng) for _ in range(4)]
            watcher = SceneWatcher()
            mog = cv2.createBackgroundSubtractorMOG2(detectShadows=False)
            knn = cv2.createBackgroundSubtractorKNN(detectShadows=False)
            ways: dict[str, Callable[[Picture], object]] = {
                "clearway": lambda f, w=watcher: w.update(f, body),
                "cv2 absdiff, threshold": lambda f, first=frames[0]: cv2.threshold(
                    cv2.absdiff(f, first), 40, 255, cv2.THRESH_BINARY
                ),
                "cv2 MOG2": mog.apply,
                "cv2 KNN": knn.apply,
            }
            took: dict[str, list[float]] = {name: [] for name in ways}
            for i in range(80):
                for name, way in ways.items():
                    began_s = time.process_time()
                    way(frames[i % 4])
                    took[name].append(1000.0 * (time.process_time() - began_s))
            ours = float(np.median(took["clearway"][20:]))
            for name, times in took.items():
                middle = float(np.median(times[20:]))
                kind = "grey" if colours == 1 else "colour"
                rows.append(
                    f"| {size[0]}x{size[1]} {kind} | {name} | {middle:.2f} | {middle / ours:.1f} |"
                )
    return rows


def reports(count: int) -> list[str]:
    """Frames until an added, removed or moved obstacle is reported, of ``count`` each."""
    rows = []
    for noise in NOISES:
        rng = np.random.default_rng(SEED)
        for what in ("added", "removed", "moved by 4 px"):
            waits = [_frames_until_reported(what, noise, rng) for _ in range(count)]
            seen = [w for w in waits if w is not None]
            within = sum(w <= 3 for w in seen)
            mean = float(np.mean(seen)) if seen else float("nan")
            rows.append(f"| {noise:g} | {what} | {within} of {count} | {mean:.2f} |")
    return rows


def _frames_until_reported(what: str, noise: float, rng: np.random.Generator) -> int | None:
    floor = arena((640, 480), rng, 5)
    side = int(rng.integers(12, 40))
    x, y = (int(v) for v in rng.integers((5, 5), (640 - side - 10, 480 - side - 10)))
    with_box, moved = floor.copy(), floor.copy()
    # On free floor, so that there is something to see.
    for picture, at in ((with_box, x), (moved, x + 4)):
        picture[max(0, y - 12) : y + side + 12, max(0, x - 12) : x + side + 16] = 190
        picture[y : y + side, at : at + side] = 40
    floor = floor.copy()
    floor[max(0, y - 12) : y + side + 12, max(0, x - 12) : x + side + 16] = 190
    before, after = {
        "added": (floor, with_box),
        "removed": (with_box, floor),
        "moved by 4 px": (with_box, moved),
    }[what]
    watcher = SceneWatcher()
    for _ in range(6):
        watcher.update(noisy(before, noise, rng), NOBODY)
    for frame in range(1, 11):
        if watcher.update(noisy(after, noise, rng), NOBODY) is not None:
            return frame
    return None


def false_reports(frames: int) -> list[str]:
    """Reports while nothing but a robot moves, over ``frames`` frames at each noise."""
    rows = []
    for noise in NOISES:
        rng = np.random.default_rng(SEED)
        floor = arena((640, 480), rng, 6)
        watcher, wrong = SceneWatcher(), 0
        for i in range(frames):
            x, y = round(320 + 250 * np.cos(0.03 * i)), round(240 + 180 * np.sin(0.047 * i))
            seen = floor.copy()
            cv2.circle(seen, (x, y), 24, 90, -1, cv2.LINE_AA)
            cv2.rectangle(seen, (x - 12, y - 12), (x + 12, y + 12), 10, -1)
            change = watcher.update(noisy(seen, noise, rng), np.array([[x, y, 27.0]]))
            wrong += change is not None and not change.first
        rows.append(f"| {noise:g} | {frames} | {wrong} |")
    return rows


def updates() -> list[str]:
    """A scene brought up to date after one new obstacle, beside a whole extraction."""
    rows = []
    for size, count in (((1280, 960), 20), ((1920, 1080), 60), ((3840, 2160), 300)):
        rng = np.random.default_rng(SEED)
        plan = Calibration.from_scale(0.002, size)
        bounds = Bounds(-1.0, -1.0, size[0] * 0.002 + 1.0, size[1] * 0.002 + 1.0)
        before = noisy(arena(size, rng, count), 3.0, rng)
        after = before.copy()
        after[200:260, 300:380] = 40
        old = vision.extract(before, polarity="dark", calibration=plan, bounds=bounds)
        known = KnownScene.of(old, plan)
        partly, whole = [], []
        for _ in range(12):
            began_s = time.process_time()
            anew = known.refitted(after, [(296, 196, 88, 68)])
            partly.append(1000.0 * (time.process_time() - began_s))
            if anew is None:
                raise SystemExit("the scene was not brought up to date")
            began_s = time.process_time()
            full = vision.extract(after, polarity="dark", calibration=plan, bounds=bounds)
            whole.append(1000.0 * (time.process_time() - began_s))
        if len(anew.scene.objects) != len(full.objects):
            raise SystemExit("the scene brought up to date is another one")
        part, all_of_it = min(partly), min(whole)
        rows.append(
            f"| {size[0]}x{size[1]}, {len(full.objects)} objects | {part:.2f} | {all_of_it:.2f} "
            f"| {part / all_of_it:.2f} |"
        )
    return rows


def calibrations(count: int) -> list[str]:
    rows = []
    folder = os.environ.get("CLEARWAY_REAL_DATA")
    if folder:
        files = sorted(Path(folder, "calibration").glob("*.jpg"))
        views, missing = find_boards(
            [(p.name, read_picture(p)) for p in files], BoardSpec("chessboard", 9, 6, 0.025)
        )
        lens = estimate_lens(views)
        rows.append(
            f"| {len(views)} real chessboards, {len(missing)} not found | {lens.rms_px:.3f} px rms "
            "| 0.20 |"
        )
    turn = cv2.Rodrigues(np.array([0.05, 0.08, 0.3]))[0] @ np.diag([1.0, -1.0, -1.0])
    pose = np.column_stack([turn, -turn @ np.array([1.0, 0.8, 2.5])])
    matrix = np.array([[1240.0, 0.0, 650.0], [0.0, 1244.0, 472.0], [0.0, 0.0, 1.0]])
    terms = np.array([-0.25, 0.07, 0.001, -0.0008, 0.01])
    truth = Calibration.from_camera((1280, 960), matrix, terms, pose)
    known = Lens((1280, 960), matrix, terms, 0.1, 5, (), ())
    rng = np.random.default_rng(SEED)
    grid = np.stack(np.meshgrid(np.arange(20, 1280, 60), np.arange(20, 960, 60)), -1).reshape(-1, 2)
    means, named = [], 0
    for _ in range(count):
        pixels = rng.uniform((20, 20), (1260, 940), (12, 2))
        places = truth.arena_from_image(pixels)
        bad = int(rng.integers(12))
        places[bad] += 0.1 * np.array([np.cos(bad), np.sin(bad)])
        names = tuple(f"point {i}" for i in range(12))
        fit = fit_arena(
            Survey(pixels + rng.normal(0, 0.1, pixels.shape), places, names), (1280, 960), known
        )
        named += [i for i, used in enumerate(fit.used) if not used] == [bad]
        off = fit.calibration.arena_from_image(grid) - truth.arena_from_image(grid)
        means.append(1000.0 * float(np.linalg.norm(off, axis=1).mean()))
    rows.append(
        f"| {count} surveys of 12 points, 0.1 px, one off by 0.1 m, at "
        f"{1000.0 * truth.metres_per_pixel:.1f} mm a pixel | {np.mean(means):.3f} mm mean over the "
        "arena | 0.5 |"
    )
    rows.append(f"| the one bad point of 12 named, no other | {named} of {count} | |")
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200)
    count = parser.parse_args().count
    text = [
        "# Watching an arena, and calibration",
        "",
        f"Rendered arenas, seed {SEED}, OpenCV {cv2.__version__}.",
        "",
        "A static arena, processor milliseconds a frame at noise 5 (median of 60):",
        "",
        "| picture | what | ms | ratio |",
        "|---|---|---|---|",
        *speed(),
        "",
        f"Changes of obstacles of 12 to 40 px in 640x480, {count} a row:",
        "",
        "| noise | obstacle | reported within 3 frames | frames, mean |",
        "|---|---|---|---|",
        *reports(count),
        "",
        "False reports while a robot drives about and nothing else moves:",
        "",
        "| noise | frames | false reports |",
        "|---|---|---|",
        *false_reports(5 * count),
        "",
        "A scene brought up to date after one new obstacle, processor milliseconds (least of 12):",
        "",
        "| arena | what changed | everything | ratio |",
        "|---|---|---|---|",
        *updates(),
        "",
        "Calibration:",
        "",
        "| what | residual | target |",
        "|---|---|---|",
        *calibrations(count),
    ]
    print("\n".join(text))
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text("\n".join(text) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
