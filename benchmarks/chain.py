"""From a picture to a path, side by side: Clearway and what one would write without it.

    python benchmarks/chain.py [--scenes 6] [--rounds 5] [--output benchmarks/results/chain.md]

(a) findContours, the Voronoi diagram of every border pixel by scipy, networkx
(b) skeletonize, sknw, networkx
(c) an expert's: approxPolyDP, points every 8 px, scipy's Delaunay, csgraph

All take the same picture and the same two places, in turn, a new picture each time, within one
run. The table holds medians in ms of processor time (of all threads, so that a busy machine does
not count), and the median of the paired ratios to ours.
Ours extracts the structure, builds the exact diagram for a robot of 6 px radius and plans; every
path's exact clearance is checked. The others know no robot: they return the length of some way.
A peer whose packages are missing is left out, and the row says so.

A second table says where our time goes, in ms of processor time: seeing, the exact diagram with
its roadmap, the plan. Beside it Boost.Polygon's Voronoi diagram of the same outlines in C++, with
arcs and circles as chords of 8 px, on whole numbers of 1/256 px: the bare diagram, and with its
edges copied out. Ours starts from the scene's records and ends with chains on their bisectors,
clearances and a proof; it holds arcs as arcs. Boost's row needs g++ and Boost's headers.
"""

from __future__ import annotations

import argparse
import ctypes
import importlib.util
import math
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import networkx as nx
import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[1]))

import planner
import vision
from planner.scene import CIRCLE, POINT, SEGMENT, Scene

Image = NDArray[np.uint8]
Place = tuple[float, float]
Chain = Callable[[Image, Place, Place], float]

RADIUS_PX = 6.0
EVERY_PX = 8.0
FRAMES = [(640, 480, 20), (1920, 1080, 60), (3840, 2160, 200)]
GAP_PX = 16.0
WHOLE_PER_PX = 256.0
"""Boost.Polygon takes whole numbers: so many to a pixel."""
NATIVE = Path(__file__).parent / "native" / "segment_diagram.cpp"


def picture(width: int, height: int, count: int, rng: np.random.Generator) -> Image:
    """Dark polygons and circles, at least ``GAP_PX`` apart, on a light ground."""
    image = np.full((height, width), 255, np.uint8)
    largest = 0.42 * math.sqrt(width * height / count) - GAP_PX / 2.0
    placed: list[tuple[float, float, float]] = []
    while len(placed) < count:
        r = float(rng.uniform(0.45, 1.0)) * largest * 0.97 ** max(0, len(placed) - count // 2)
        for _ in range(400):
            x = float(rng.uniform(r + 2 * GAP_PX, width - r - 2 * GAP_PX))
            y = float(rng.uniform(r + 2 * GAP_PX, height - r - 2 * GAP_PX))
            if all(math.hypot(x - u, y - v) > r + s + GAP_PX for u, v, s in placed):
                break
        else:
            largest *= 0.9
            continue
        placed.append((x, y, r))
        if len(placed) % 4 == 0:
            cv2.circle(image, (round(x), round(y)), round(r), 0, -1)
            continue
        corners = int(rng.integers(3, 9))
        angles = (np.arange(corners) + rng.uniform(-0.3, 0.3, corners)) * math.tau / corners
        reach = np.where(np.arange(corners) % 2, rng.uniform(0.5, 1.0), 1.0) * r
        outline = np.c_[x + reach * np.cos(angles), y + reach * np.sin(angles)]
        cv2.fillPoly(image, [np.round(outline).astype(np.int32)], 0)
    return image


def clearway(image: Image, start: Place, goal: Place) -> float:
    scene = vision.extract(image)
    path = planner.build_roadmap(scene, RADIUS_PX).plan(start, goal)
    if isinstance(path, planner.NoPath):
        raise SystemExit(f"no path: {path.reason}")
    if path.min_clearance < RADIUS_PX * (1.0 - 1e-6):
        raise SystemExit(f"clearance {path.min_clearance}: must be >= {RADIUS_PX}")
    return path.length


def _outlines(image: Image, how: int) -> list[NDArray[np.int32]]:
    """The obstacles' outlines, and the picture's frame."""
    found, _ = cv2.findContours(255 - image, cv2.RETR_EXTERNAL, how)
    h, w = image.shape
    frame = np.array([(0, 0), (w - 1, 0), (w - 1, h - 1), (0, h - 1)], np.int32)
    return [c.reshape(-1, 2) for c in found] + [frame]


def _resampled(outline: NDArray[np.int32], step: float) -> NDArray[np.float64]:
    corners = outline.astype(float)
    parts = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        n = max(1, math.ceil(math.dist(a, b) / step))
        parts.append(a + np.arange(n)[:, None] / n * (b - a))
    return np.concatenate(parts)


def _nearest(places: NDArray[np.float64], place: Place) -> int:
    return int(np.argmin(((places - place) ** 2).sum(axis=1)))


def every_border_pixel(image: Image, start: Place, goal: Place) -> float:
    from scipy.spatial import Voronoi

    outlines = [_resampled(o, 1.0) for o in _outlines(image, cv2.CHAIN_APPROX_NONE)]
    owner = np.repeat(np.arange(len(outlines)), [len(o) for o in outlines])
    diagram = Voronoi(np.concatenate(outlines))
    graph: nx.Graph[int] = nx.Graph()
    for (i, j), (a, b) in zip(diagram.ridge_points, diagram.ridge_vertices, strict=True):
        if a >= 0 and b >= 0 and owner[i] != owner[j]:
            step = diagram.vertices[a] - diagram.vertices[b]
            graph.add_edge(a, b, weight=float(np.hypot(*step)))
    nodes = np.array(list(graph))
    ends = [nodes[_nearest(diagram.vertices[nodes], p)] for p in (start, goal)]
    return float(nx.dijkstra_path_length(graph, *ends))


def skeleton(image: Image, start: Place, goal: Place) -> float:
    import sknw
    from skimage.morphology import skeletonize

    graph = sknw.build_sknw(skeletonize(image > 127).astype(np.uint16))
    nodes = np.array(list(graph))
    places = np.array([graph.nodes[n]["o"] for n in nodes])[:, ::-1]
    ends = [nodes[_nearest(places, p)] for p in (start, goal)]
    return float(nx.dijkstra_path_length(graph, *ends))


def expert(image: Image, start: Place, goal: Place) -> float:
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import dijkstra
    from scipy.spatial import Delaunay

    outlines = [
        _resampled(cv2.approxPolyDP(o.reshape(-1, 1, 2), 1.0, True).reshape(-1, 2), EVERY_PX)
        for o in _outlines(image, cv2.CHAIN_APPROX_SIMPLE)
    ]
    xy = np.concatenate(outlines)
    owner = np.repeat(np.arange(len(outlines)), [len(o) for o in outlines])
    mesh = Delaunay(xy)
    corners = mesh.simplices
    a, b, c = (xy[corners[:, k]] for k in range(3))
    u, v = b - a, c - a
    twice = 2.0 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    uu, vv = (u * u).sum(axis=1), (v * v).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = (v[:, 1] * uu - u[:, 1] * vv) / twice
        y = (u[:, 0] * vv - v[:, 0] * uu) / twice
    centre = a + np.c_[x, y]
    who = owner[corners]
    differ = who[:, [1, 2, 0]] != who[:, [2, 0, 1]]
    keep = (mesh.neighbors > np.arange(len(corners))[:, None]) & differ
    t, k = np.nonzero(keep)
    other = mesh.neighbors[t, k]
    length = np.hypot(*(centre[t] - centre[other]).T)
    fine = np.isfinite(length)
    graph = csr_matrix((length[fine], (t[fine], other[fine])), shape=(len(corners),) * 2)
    used = np.unique(np.concatenate([t[fine], other[fine]]))
    ends = [used[_nearest(centre[used], p)] for p in (start, goal)]
    return float(dijkstra(graph, directed=False, indices=ends[0])[ends[1]])


def whole_segments(scene: Scene) -> NDArray[np.int32]:
    """The scene's sides and walls, arcs as chords, as rows of whole numbers for Boost.Polygon."""
    flat = scene.primitives()
    rows: list[NDArray[np.float64]] = []
    for kind, row in zip(flat.kind.tolist(), flat.data, strict=True):
        if kind == SEGMENT:
            rows.append(row[:4].reshape(2, 2))
            continue
        if kind == POINT:
            continue
        start, sweep = (0.0, math.tau) if kind == CIRCLE else (row[3], row[4])
        n = max(8 if kind == CIRCLE else 2, math.ceil(sweep * row[2] / EVERY_PX)) + 1
        a = start + sweep * np.linspace(0.0, 1.0, n)
        rows.append(row[:2] + row[2] * np.c_[np.cos(a), np.sin(a)])
    lines = [np.round(r * WHOLE_PER_PX).astype(np.int32) for r in rows]
    segments = np.concatenate([np.c_[line[:-1], line[1:]] for line in lines])
    lengthy = (segments[:, :2] != segments[:, 2:]).any(axis=1)
    return np.ascontiguousarray(segments[lengthy])


def boost_diagram() -> Callable[[NDArray[np.int32], bool], int] | str:
    """Boost.Polygon's segment diagram, compiled now; or why there is none."""
    library = Path(tempfile.mkdtemp()) / "segments.so"
    command = ["g++", "-std=c++17", "-O3", "-DNDEBUG", "-march=native", "-fPIC", "-shared"]
    try:
        done = subprocess.run(
            [*command, str(NATIVE), "-o", str(library)], capture_output=True, check=False
        )
    except FileNotFoundError:
        return "needs g++"
    if done.returncode:
        return "needs Boost's headers"
    function = ctypes.CDLL(str(library)).segment_diagram
    function.restype = ctypes.c_long
    function.argtypes = [ctypes.c_void_p, ctypes.c_long, ctypes.c_void_p]

    def run(segments: NDArray[np.int32], copied: bool) -> int:
        n = len(segments)
        places = np.empty((9 * n + 64, 4)) if copied else None
        return int(
            function(segments.ctypes.data, n, None if places is None else places.ctypes.data)
        )

    return run


def shares(frames: list[tuple[int, int, int]], scenes: int, rounds: int) -> list[str]:
    """The second table's rows."""
    boost = boost_diagram()
    names = ["seeing", "diagram and roadmap", "plan"]
    if not isinstance(boost, str):
        names += ["Boost.Polygon, bare", "Boost.Polygon, edges copied"]
    cells: dict[str, list[str]] = {name: [] for name in names}
    for width, height, count in frames:
        rng = np.random.default_rng([width, count])
        pictures = [picture(width, height, count, rng) for _ in range(scenes)]
        taken: dict[str, list[float]] = {name: [] for name in names}
        for turn in range(rounds + 1):
            for image in pictures:
                laps = [time.thread_time()]
                scene = vision.extract(image)
                laps.append(time.thread_time())
                roadmap = planner.build_roadmap(scene, RADIUS_PX)
                laps.append(time.thread_time())
                roadmap.plan((14.0, 14.0), (width - 15.0, height - 15.0))
                laps.append(time.thread_time())
                if not isinstance(boost, str):
                    segments = whole_segments(scene)
                    for copied in (False, True):
                        begun = time.thread_time()
                        boost(segments, copied)
                        laps.append(laps[-1] + time.thread_time() - begun)
                if turn:
                    for name, lap in zip(names, np.diff(laps).tolist(), strict=True):
                        taken[name].append(lap)
        ours = taken["diagram and roadmap"]
        for name, laps in taken.items():
            text = f"{statistics.median(laps) * 1e3:.2f}"
            if name.startswith("Boost"):
                ratio = statistics.median(b / o for b, o in zip(laps, ours, strict=True))
                text += f" ({ratio:.1f} x)"
            cells[name].append(text)
    rows = ["| stage | " + " | ".join(f"{w}x{h}/{n}" for w, h, n in frames) + " |"]
    rows.append("|---" * (len(frames) + 1) + "|")
    rows += [f"| {name} | {' | '.join(values)} |" for name, values in cells.items()]
    if isinstance(boost, str):
        rows.append(f"| Boost.Polygon | {boost} |" + " |" * (len(frames) - 1))
    return rows


CHAINS: dict[str, tuple[Chain, tuple[str, ...]]] = {
    "Clearway": (clearway, ()),
    "(a) every border pixel": (every_border_pixel, ("scipy",)),
    "(b) skeleton": (skeleton, ("skimage", "sknw")),
    "(c) an expert's": (expert, ("scipy",)),
}


def measure(frames: list[tuple[int, int, int]], scenes: int, rounds: int) -> list[str]:
    """The table's rows."""
    rows = ["| method | " + " | ".join(f"{w}x{h}/{n}" for w, h, n in frames) + " |"]
    rows.append("|---" * (len(frames) + 1) + "|")
    cells: dict[str, list[str]] = {name: [] for name in CHAINS}
    for width, height, count in frames:
        rng = np.random.default_rng([width, count])
        pictures = [picture(width, height, count, rng) for _ in range(scenes)]
        times = _time_all(pictures, rounds)
        ours = times["Clearway"]
        for name, taken in times.items():
            ratio = statistics.median(t / o for t, o in zip(taken, ours, strict=True))
            cells[name].append(f"{statistics.median(taken) * 1e3:.2f} ({ratio:.1f} x)")
    for name, values in cells.items():
        missing = _missing(name)
        text = f"needs {', '.join(missing)}" if missing else " | ".join(values)
        rows.append(f"| {name} | {text} |")
    return rows


def _missing(name: str) -> list[str]:
    return [m for m in CHAINS[name][1] if importlib.util.find_spec(m) is None]


def _time_all(pictures: list[Image], rounds: int) -> dict[str, list[float]]:
    times: dict[str, list[float]] = {name: [] for name in CHAINS if not _missing(name)}
    start = (14.0, 14.0)
    for round_number in range(rounds + 1):
        for image in pictures:
            goal = (image.shape[1] - 15.0, image.shape[0] - 15.0)
            for name, taken in times.items():
                slow = name != "Clearway" and round_number > 2
                if slow and sum(taken) > 20.0:
                    taken.append(taken[-len(pictures)])
                    continue
                begun = time.process_time()
                CHAINS[name][0](image, start, goal)
                if round_number:
                    taken.append(time.process_time() - begun)
    return times


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=6)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--frames", type=int, default=len(FRAMES), help="how many of the sizes")
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    frames = FRAMES[: options.frames]
    rows = measure(frames, options.scenes, options.rounds)
    parts = shares(frames, options.scenes, options.rounds)
    head = (
        "# Picture to path, beside its peers\n\n"
        "Medians of processor time in ms (ratio to Clearway),"
        f" {platform.machine()}, Python {platform.python_version()}, radius {RADIUS_PX:g} px\n"
    )
    middle = "\nWhere the time goes, processor time in ms (Boost's ratio to diagram and roadmap)\n"
    text = "\n".join([head, *rows, middle, *parts]) + "\n"
    print(text)
    if options.output:
        options.output.write_text(text)


if __name__ == "__main__":
    main()
