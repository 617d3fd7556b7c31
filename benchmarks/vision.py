"""Corners, circles, arcs, cover, counts and speed of the extractor beside OpenCV, with truth.

Run ``python -m benchmarks.vision [--count 200] [--only corners,speed] [--cells 0.7/20,8]``: prints
the tables and keeps them in ``benchmarks/results/vision.md``, section by section: what is not
run stays as it was. ``--cells`` keeps the rows whose first column begins so, and is not kept.
Seeds are in the file. Times are processor time, the least of several interleaved runs on one
thread; they vary from machine to machine: compare the ratios.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from planner.scene import Arc, CircleRecord, PolygonRecord, object_records
from tests.support.drawn.render import coverage, cut_disc, draw, outline_points, polygon, ramp
from vision import extract

SEED = 20
CELLS = [(0.7, 0.0), (0.7, 5.0), (0.7, 10.0), (0.7, 20.0), (1.5, 0.0), (1.5, 20.0)]
NEAR_PX = 3.0


def shape(rng: np.random.Generator) -> np.ndarray:
    """A polygon of 90 to 120 degrees or an L, sides of 20 to 50 px, at any angle."""
    kind = rng.integers(0, 3)
    if kind == 0:
        w, h = rng.uniform(20, 50, 2)
        v = np.array([(0, 0), (w, 0), (w, h), (0, h)])
    elif kind == 1:
        p, q, r, s = rng.uniform(20, 30, 4)
        v = np.array([(0, 0), (p + r, 0), (p + r, q), (p, q), (p, q + s), (0, q + s)])
    else:
        n = rng.integers(5, 7)
        t = np.arange(n) * math.tau / n
        v = rng.uniform(26, 44) * np.stack([np.cos(t), np.sin(t)], axis=1)
    a = rng.uniform(0, math.tau)
    turn = np.array([[math.cos(a), math.sin(a)], [-math.sin(a), math.cos(a)]])
    return (v - v.mean(axis=0)) @ turn + 60.0 + rng.uniform(-0.5, 0.5, 2)


def ours(picture: np.ndarray) -> np.ndarray:
    records = [r for o in extract(picture).objects for r in object_records(o)]
    found = [e.start for r in records if isinstance(r, PolygonRecord) for e in r.edges]
    return np.array(found).reshape(-1, 2)


def the_paper(picture: np.ndarray) -> np.ndarray:
    records = [r for o in extract(picture, mode="paper").objects for r in object_records(o)]
    found = [e.start for r in records if isinstance(r, PolygonRecord) for e in r.edges]
    return np.array(found).reshape(-1, 2)


def opencv_corners(picture: np.ndarray) -> np.ndarray:
    contour = largest(picture)
    return cv2.approxPolyDP(contour, 2.0, True).reshape(-1, 2).astype(float)


def largest(picture: np.ndarray) -> np.ndarray:
    binary = cv2.threshold(cv2.medianBlur(picture, 3), 127, 255, cv2.THRESH_BINARY_INV)[1]
    contours = cv2.findContours(binary, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)[0]
    return max(contours, key=len)


def wanted(cell: str, cells: list[str]) -> bool:
    """Whether a row is asked for, by the beginning of its first column."""
    return not cells or any(cell.startswith(one) for one in cells)


def corner_table(count: int, cells: list[str]) -> list[str]:
    lines = [
        "| blur / noise | method | corners rms px | missed | false |",
        "|---|---|---|---|---|",
    ]
    methods: dict[str, Callable[[np.ndarray], np.ndarray]] = {
        "clearway": ours,
        "clearway --paper": the_paper,
        "cv2.approxPolyDP, 2 px": opencv_corners,
    }
    for blur, noise in CELLS:
        if not wanted(f"{blur}/{noise:.0f}", cells):
            continue
        results: dict[str, list[float]] = {name: [0.0, 0.0, 0.0, 0.0] for name in methods}
        total = 0
        for i in range(count):
            rng = np.random.default_rng([SEED, i, int(blur * 10), int(noise)])
            truth = shape(rng)
            picture = draw([polygon(truth)], (120, 120), blur=blur, noise=noise, rng=rng)
            total += len(truth)
            for name, method in methods.items():
                score = results[name]
                found = method(picture)
                used = set()
                for corner in truth:
                    d = np.hypot(*(found - corner).T) if len(found) else np.array([math.inf])
                    if d.min() < NEAR_PX:
                        score[0] += float(d.min() ** 2)
                        score[1] += 1
                        used.add(int(d.argmin()))
                    else:
                        score[2] += 1
                score[3] += len(found) - len(used)
        for name, (square, hits, missed, false) in results.items():
            rms = math.sqrt(square / max(hits, 1))
            lines.append(
                f"| {blur} / {noise:.0f} | {name} | {rms:.3f} | {missed / total:.1%} "
                f"| {false / total:.1%} |"
            )
    return lines


def circle_table(count: int, cells: list[str]) -> list[str]:
    lines = [
        "| radius, noise | method | found | radius rms px | centre rms px |",
        "|---|---|---|---|---|",
    ]
    for radius in (5, 8, 20, 50, 100):
        for noise in (0.0, 10.0, 20.0):
            if not wanted(f"{radius},{noise:.0f}", cells):
                continue
            rows: dict[str, list[tuple[float, float]]] = {
                "clearway": [], "cv2.fitEllipse": [], "cv2.minEnclosingCircle": [],
                "cv2.HoughCircles": [],
            }  # fmt: skip
            size = 2 * radius + 40
            for i in range(count):
                rng = np.random.default_rng([SEED, i, radius, int(noise)])
                center = size / 2 + rng.uniform(-0.5, 0.5, 2)
                record = CircleRecord((float(center[0]), float(center[1])), float(radius))
                picture = draw([record], (size, size), noise=noise, rng=rng)
                for name, found in circles(picture, radius).items():
                    if found is not None:
                        x, y, r = found
                        error = (r - radius, math.hypot(x - center[0], y - center[1]))
                        rows[name].append(error)
            for name, errors in rows.items():
                rms = np.sqrt(np.mean(np.square(errors), axis=0)) if errors else (math.nan,) * 2
                lines.append(
                    f"| {radius}, {noise:.0f} | {name} | {len(errors) / count:.0%} "
                    f"| {rms[0]:.3f} | {rms[1]:.3f} |"
                )
    return lines


def circles(picture: np.ndarray, radius: float) -> dict[str, tuple[float, float, float] | None]:
    records = [r for o in extract(picture).objects for r in o.records]
    own = records[0] if len(records) == 1 and isinstance(records[0], CircleRecord) else None
    contour = largest(picture)
    (ex, ey), (a, b), _ = cv2.fitEllipse(contour)
    (mx, my), mr = cv2.minEnclosingCircle(contour)
    hough = cv2.HoughCircles(
        picture, cv2.HOUGH_GRADIENT, 1, 20, param1=100, param2=12,
        minRadius=int(radius * 0.7), maxRadius=int(radius * 1.3) + 1,
    )  # fmt: skip
    seen = None if hough is None else tuple(hough.reshape(-1, 3)[0].tolist())
    return {
        "clearway": None if own is None else (*own.center, own.radius),
        "cv2.fitEllipse": (ex, ey, (a + b) / 4.0),
        "cv2.minEnclosingCircle": (mx, my, mr),
        "cv2.HoughCircles": seen,
    }


def arc_table(count: int, cells: list[str]) -> list[str]:
    """Discs with a piece cut off: the arc that is left, against a circle through everything."""
    lines = [
        "| radius, half the cut, noise | method | found | radius rms px | centre rms px |",
        "|---|---|---|---|---|",
    ]
    for radius in (20, 50):
        for half in (0.6, 1.5):
            for noise in (0.0, 10.0, 20.0):
                cell = f"{radius}, {half}, {noise:.0f}"
                if not wanted(cell.replace(" ", ""), cells):
                    continue
                errors: dict[str, list[tuple[float, float]]] = {
                    "clearway": [], "cv2.fitEllipse": [], "cv2.minEnclosingCircle": [],
                }  # fmt: skip
                for i in range(count):
                    rng = np.random.default_rng([SEED, i, radius, int(half * 10), int(noise)])
                    size = 2 * radius + 40
                    center = size / 2 + rng.uniform(-0.5, 0.5, 2)
                    disc = cut_disc(center, radius, rng.uniform(0, math.tau), half)
                    picture = draw([disc], (size, size), noise=noise, rng=rng)
                    for name, found in arcs(picture).items():
                        if found is not None:
                            x, y, r = found
                            away = math.hypot(x - center[0], y - center[1])
                            errors[name].append((r - radius, away))
                for name, pairs in errors.items():
                    rms = np.sqrt(np.mean(np.square(pairs), axis=0)) if pairs else (math.nan,) * 2
                    lines.append(
                        f"| {cell} | {name} | {len(pairs) / count:.0%} | {rms[0]:.3f} "
                        f"| {rms[1]:.3f} |"
                    )
    return lines


def arcs(picture: np.ndarray) -> dict[str, tuple[float, float, float] | None]:
    """The arc of the only object: ours counts where the record is one line and one arc."""
    records = [r for o in extract(picture).objects for r in o.records]
    own = None
    if len(records) == 1 and isinstance(records[0], PolygonRecord) and len(records[0].edges) == 2:
        bent = [e for e in records[0].edges if isinstance(e, Arc)]
        own = (*bent[0].center, bent[0].radius) if len(bent) == 1 else None
    contour = largest(picture)
    (ex, ey), (a, b), _ = cv2.fitEllipse(contour)
    (mx, my), mr = cv2.minEnclosingCircle(contour)
    return {
        "clearway": own,
        "cv2.fitEllipse": (ex, ey, (a + b) / 4.0),
        "cv2.minEnclosingCircle": (mx, my, mr),
    }


def outline(rng: np.random.Generator, kind: str) -> np.ndarray:
    """A mask (200, 200) of one crisp object."""
    angle = rng.uniform(0, math.tau)
    y, x = np.mgrid[0:200, 0:200] - 100.0 - rng.uniform(-0.5, 0.5, 2)[:, None, None]
    u = x * math.cos(angle) + y * math.sin(angle)
    v = y * math.cos(angle) - x * math.sin(angle)
    if kind == "rectangle":
        w, h = rng.uniform(11, 65, 2)
        return (abs(u) <= w) & (abs(v) <= h)
    if kind == "disc":
        return np.hypot(u, v) <= rng.uniform(12, 85)
    if kind == "half disc":
        return (np.hypot(u, v) <= rng.uniform(20, 85)) & (v >= 0)
    if kind == "stadium":
        return np.hypot(np.maximum(abs(u) - rng.uniform(8, 45), 0), v) <= rng.uniform(12, 40)
    if kind == "ellipse":
        a, b = rng.uniform(14, 85, 2)
        return (u / a) ** 2 + (v / b) ** 2 <= 1
    if kind == "blob":
        t = np.arctan2(v, u)
        waves = 1 + 0.18 * np.sin(3 * t) + 0.08 * np.cos(5 * t + 1)
        return np.hypot(u, v) <= rng.uniform(30, 70) * waves
    n = 2 * int(rng.integers(4, 8))
    r = rng.uniform(25, 85) * np.where(np.arange(n) % 2, rng.uniform(0.4, 0.75), 1.0)
    t = angle + np.arange(n) * math.tau / n
    star = 100 + np.stack([r * np.cos(t), r * np.sin(t)], axis=1)
    return coverage([star], (200, 200), lines=1) >= 0.5


def cover_table(count: int, cells: list[str]) -> list[str]:
    """Records of crisp objects of 400 px and more drawn again, beside approxPolyDP's."""
    lines = [
        "| shape | method | least IoU | below 0.995 | most Hausdorff px | edges, mean |",
        "|---|---|---|---|---|---|",
    ]
    for kind in ("rectangle", "disc", "half disc", "stadium", "star", "ellipse", "blob"):
        if not wanted(kind, cells):
            continue
        rows: dict[str, list[tuple[float, float, int]]] = {
            "clearway": [], "cv2.approxPolyDP, 1 px": [],
        }  # fmt: skip
        for i in range(count):
            mask = outline(np.random.default_rng([SEED, i, len(kind)]), kind)
            if mask.sum() < 400:
                continue
            picture = np.where(mask, 0, 255).astype(np.uint8)
            records = [r for o in extract(picture).objects for r in object_records(o)]
            drawn = [outline_points(r, 0.01) for r in records]
            again = coverage(drawn, (200, 200), lines=1) >= 0.5
            edges = sum(len(r.edges) if isinstance(r, PolygonRecord) else 1 for r in records)
            rows["clearway"].append((*alike(mask, again), edges))
            polyline = cv2.approxPolyDP(largest(picture), 1.0, True)
            filled = np.zeros((200, 200), np.uint8)
            cv2.fillPoly(filled, [polyline], 1)
            rows["cv2.approxPolyDP, 1 px"].append((*alike(mask, filled > 0), len(polyline)))
        for name, found in rows.items():
            overlap, away, edges = np.array(found).T
            lines.append(
                f"| {kind} | {name} | {overlap.min():.4f} | {int((overlap < 0.995).sum())} of "
                f"{len(found)} | {away.max():.2f} | {edges.mean():.1f} |"
            )
    return lines


def alike(a: np.ndarray, b: np.ndarray) -> tuple[float, float]:
    """Intersection over union of two masks, and their symmetric Hausdorff distance in pixels."""
    away = [
        cv2.distanceTransform((~m).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        for m in (a, b)
    ]
    return float((a & b).sum() / (a | b).sum()), float(max(away[0][b].max(), away[1][a].max()))


def count_table(count: int, cells: list[str]) -> list[str]:
    """How many pictures have as many objects as were drawn."""
    lines = ["| noise | method | counted right |", "|---|---|---|"]
    for noise in (0.0, 5.0, 10.0, 20.0):
        if not wanted(f"{noise:.0f}", cells):
            continue
        right = {"clearway": 0, "cv2.findContours": 0}
        for i in range(count):
            rng = np.random.default_rng([SEED, i, int(noise)])
            objects = int(rng.integers(3, 25))
            picture = taken(arena((640, 480), objects, i), noise, rng)
            right["clearway"] += len(extract(picture).objects) == objects
            right["cv2.findContours"] += len(opencv_contours(picture)[0]) == objects
        lines += [f"| {noise:.0f} | {name} | {hits / count:.1%} |" for name, hits in right.items()]
    return lines


def ramp_table(count: int, cells: list[str]) -> list[str]:
    """The same where light falls off across the picture; at most 20 scenes a cell."""
    count = min(count, 20)
    lines = [
        f"{count} scenes a cell, of 1 to 12 discs.",
        "",
        "| ramp, noise, share | dark counted right | light counted right |",
        "|---|---|---|",
    ]
    size = (640, 480)
    for share in (0.0005, 0.005, 0.05, 0.3):
        scenes = [discs(size, share, np.random.default_rng([SEED, i])) for i in range(count)]
        covers = [coverage([outline_points(d) for d in scene], size, lines=4) for scene in scenes]
        for fall in (0.0, 0.6, 0.8):
            for noise in (0.0, 10.0, 20.0):
                name = f"{fall:.0%}, {noise:.0f}, {share:.2%}"
                if not wanted(name.replace(" ", ""), cells):
                    continue
                right = {"dark": 0, "light": 0}
                for i, (scene, cover) in enumerate(zip(scenes, covers, strict=True)):
                    rng = np.random.default_rng([SEED, i, int(noise)])
                    lit = ramp(size, fall, rng.uniform(0.0, math.tau))
                    for side in right:
                        dark, light = (40.0, 215.0) if side == "dark" else (215.0, 40.0)
                        grey = cv2.GaussianBlur(light + (dark - light) * cover, (0, 0), 0.7) * lit
                        grey += rng.normal(0.0, noise, grey.shape)
                        picture = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
                        objects = extract(picture, polarity=side).objects
                        whole = not any(one.holes for one in objects)
                        right[side] += len(objects) == len(scene) and whole
                lines.append(f"| {name} | {right['dark']} | {right['light']} |")
    return lines


def discs(size: tuple[int, int], share: float, rng: np.random.Generator) -> list[CircleRecord]:
    """Discs of one size that cover a share of the picture, each in a cell of its own."""
    columns, rows = (1, 1) if share < 0.001 else (2, 2) if share < 0.002 else (4, 3)
    width, height = size[0] / columns, size[1] / rows
    radius = math.sqrt(share * width * height / math.pi)
    slack = min(20.0, min(width, height) / 2.0 - radius - 4.0)
    return [
        CircleRecord(
            (
                float((i + 0.5) * width + rng.uniform(-slack, slack)),
                float((j + 0.5) * height + rng.uniform(-slack, slack)),
            ),
            radius,
        )
        for i in range(columns)
        for j in range(rows)
    ]


def taken(drawn: np.ndarray, noise: float, rng: np.random.Generator) -> np.ndarray:
    """A drawing as a camera sees it: blurred, with less contrast, and noisy."""
    seen = cv2.GaussianBlur(drawn, (0, 0), 0.7).astype(np.float32) * np.float32(0.7) + 40.0
    if noise > 0.0:
        seen += rng.normal(0.0, noise, drawn.shape).astype(np.float32)
    return np.clip(np.rint(seen), 0, 255).astype(np.uint8)


def arena(size: tuple[int, int], count: int, seed: int) -> np.ndarray:
    """Polygons and discs on a jittered grid, without grey."""
    rng = np.random.default_rng([SEED, seed, count])
    width, height = size
    columns = math.ceil(math.sqrt(count * width / height))
    rows = math.ceil(count / columns)
    cell = min(width / columns, height / rows)
    picture = np.full((height, width), 255, np.uint8)
    for i in range(count):
        x = (i % columns + 0.5) * width / columns
        y = (i // columns + 0.5) * height / rows
        radius = cell * rng.uniform(0.25, 0.42)
        if i % 3 == 0:
            cv2.circle(picture, (round(x), round(y)), round(radius), 0, -1, cv2.LINE_AA)
            continue
        n = int(rng.integers(3, 8))
        angles = (np.arange(n) + rng.uniform(-0.3, 0.3, n)) * math.tau / n
        radii = radius * (1.0 if i % 3 == 1 else np.where(np.arange(n) % 2, 0.6, 1.0))
        points = np.stack([x + radii * np.cos(angles), y + radii * np.sin(angles)], axis=1)
        cv2.fillPoly(picture, [np.rint(points * 16).astype(np.int32)], 0, cv2.LINE_AA, 4)
    return picture


def speed_table(cells: list[str]) -> list[str]:
    """Picture to scene against median blur, threshold and findContours on the same frames."""
    lines = [
        "| frame | objects | picture | border px | OpenCV ms | clearway ms | ratio "
        "| fit, ns a border px | all, ns a border px |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    cv2.setNumThreads(1)
    for size, count in [
        ((640, 480), 7), ((640, 480), 20), ((1280, 960), 20), ((1920, 1080), 60),
        ((3840, 2160), 200), ((3840, 2160), 800),
    ]:  # fmt: skip
        frame = f"{size[0]}x{size[1]}"
        if not wanted(frame, cells):
            continue
        rng = np.random.default_rng([SEED, count])
        drawn = arena(size, count, 0)
        pictures = {
            "anti-aliased": drawn,
            "black and white": cv2.threshold(drawn, 127, 255, cv2.THRESH_BINARY)[1],
            "noise 5": taken(drawn, 5.0, rng),
            "noise 20": taken(drawn, 20.0, rng),
        }
        for name, picture in pictures.items():
            reference, own, fit = least_ms(picture)
            scene = extract(picture)
            note = "" if len(scene.objects) == count else " (WRONG)"
            pixels = scene.border_pixels
            lines.append(
                f"| {frame} | {count}{note} | {name} | {pixels} | {reference:.2f} | {own:.2f} "
                f"| {own / reference:.1f} | {1e6 * fit / pixels:.0f} | {1e6 * own / pixels:.0f} |"
            )
    return lines


def opencv_contours(picture: np.ndarray) -> tuple[Sequence[np.ndarray], object]:
    binary = cv2.threshold(cv2.medianBlur(picture, 3), 127, 255, cv2.THRESH_BINARY_INV)[1]
    return cv2.findContours(binary, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)


def least_ms(picture: np.ndarray) -> tuple[float, float, float]:
    """The least processor time of OpenCV and of ours, and the least wall time of our fit."""
    reference = own = fit = math.inf
    extract(picture)
    for _ in range(15):
        begin = time.process_time()
        opencv_contours(picture)
        middle = time.process_time()
        scene = extract(picture)
        end = time.process_time()
        reference = min(reference, 1e3 * (middle - begin))
        own = min(own, 1e3 * (end - middle))
        fit = min(fit, scene.timings_ms["geometry"])
    return reference, own, fit


def section(text: str, name: str) -> str:
    """A section of the last results, without its heading."""
    found = re.search(rf"^## {name}\n\n(.*?)(?=^## |\Z)", text, re.DOTALL | re.MULTILINE)
    return "" if found is None else found.group(1).strip()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200, help="scenes in a cell")
    parser.add_argument("--only", default="", help="sections, with commas between")
    parser.add_argument("--cells", default="", help="beginnings of first columns; not kept")
    options = parser.parse_args()
    count = options.count
    cells = [one for one in options.cells.split(",") if one]
    tables: dict[str, Callable[[], list[str]]] = {
        "corners": lambda: corner_table(count, cells),
        "circles": lambda: circle_table(count, cells),
        "arcs": lambda: arc_table(count, cells),
        "cover": lambda: cover_table(count, cells),
        "counts": lambda: count_table(count, cells),
        "ramps": lambda: ramp_table(count, cells),
        "speed": lambda: speed_table(cells),
    }
    results = Path(__file__).with_name("results") / "vision.md"
    results.parent.mkdir(exist_ok=True)
    asked = [one for one in options.only.split(",") if one] or list(tables)
    for name in asked:
        table = f"{count} scenes a cell.\n\n" if name not in ("ramps", "speed") else ""
        table += "\n".join(tables[name]())
        print(f"## {name}\n\n{table}\n", flush=True)
        if cells:
            continue
        last = results.read_text(encoding="utf-8") if results.exists() else ""
        parts = [f"# Vision beside OpenCV {cv2.__version__}"]
        for other in tables:
            body = table if other == name else section(last, other)
            if body:
                parts.append(f"## {other}\n\n{body}")
        results.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
