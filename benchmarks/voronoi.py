"""Voronoi diagrams of points, side by side: ours, CGAL, Boost.Polygon, Qhull, OpenCV, Triangle.

    python benchmarks/voronoi.py [--most 1e6] [--output benchmarks/results/voronoi.md]

Every method gets the same inputs in turn, a new one each time, and is timed within one run, one
after the other per input, in CPU time of its thread; the table holds medians, and the median of
the paired ratios to ours. "Arrays": from the sites to the pairs of neighbours and the finite
vertices in arrays. "Build": the bare diagram inside the library, which favours the C++ peers.
Sites: uniform at random, and along the outlines of polygons, circles and walls, about 8 px
apart, in outline order.

Needs, for the peers, scipy, opencv, pyvoronoi, triangle, and g++ with the headers of CGAL and
Boost; a row says what is missing.
"""

from __future__ import annotations

import argparse
import ctypes
import importlib
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[1]))

import planner
from planner.delaunay.voronoi_diagram import voronoi_arrays

Sites = NDArray[np.float64]
Method = Callable[[Sites], object]

SIDE_PX = 4000.0
SPACING_PX = 8.0
NATIVE = Path(__file__).parent / "native" / "point_diagrams.cpp"
FLAGS = ["-std=c++17", "-O3", "-DNDEBUG", "-march=native", "-frounding-math", "-fPIC", "-shared"]
SLOWEST_S = 20.0
"""A method expected to take longer than this on one input is left out there."""


def random_sites(n: int, rng: np.random.Generator) -> Sites:
    return rng.random((n, 2)) * SIDE_PX


def outline_sites(n: int, rng: np.random.Generator) -> Sites:
    """n samples of walls, polygons and circles on a jittered grid, in outline order."""
    perimeter = 700.0
    per_object = perimeter / SPACING_PX
    columns = max(1, int(np.ceil(np.sqrt(n / per_object))))
    pitch = 400.0
    width = columns * pitch
    walls = _sampled(np.array([(0, 0), (width, 0), (width, width), (0, width)]))
    # a small part of a scene has its share of the walls
    outlines = [walls[:: max(1, -(-4 * len(walls) // n))]]
    total = len(outlines[0])
    while total < n:
        k = len(outlines) - 1
        centre = (np.array([k % columns, k // columns]) + rng.uniform(0.42, 0.58, 2)) * pitch
        corners = int(rng.integers(3, 9))
        radius = rng.uniform(80.0, 130.0)
        if rng.random() < 0.3:
            angle = np.arange(0.0, 2.0 * np.pi, SPACING_PX / radius)
            outline = centre + radius * np.column_stack((np.cos(angle), np.sin(angle)))
        else:
            turn = (np.arange(corners) + rng.uniform(-0.3, 0.3, corners)) * 2.0 * np.pi / corners
            outline = _sampled(centre + radius * np.column_stack((np.cos(turn), np.sin(turn))))
        outlines.append(outline)
        total += len(outline)
    return np.ascontiguousarray(np.vstack(outlines)[:n])


def _sampled(corners: Sites) -> Sites:
    sides = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        steps = max(1, round(float(np.hypot(*(b - a))) / SPACING_PX))
        sides.append(a + (np.arange(steps) / steps)[:, None] * (b - a))
    return np.vstack(sides)


def native_methods(missing: dict[str, str]) -> dict[str, Method]:
    """CGAL and Boost.Polygon, each compiled alone, so that one can do without the other."""
    methods: dict[str, Method] = {}
    for name, macro, libraries in (
        ("CGAL Delaunay, C++", "CGAL", ["-lgmp", "-lmpfr"]),
        ("Boost.Polygon, C++", "BOOST", []),
    ):
        library = Path(tempfile.mkdtemp()) / f"{macro.lower()}.so"
        command = ["g++", *FLAGS, f"-DWITH_{macro}", str(NATIVE), "-o", str(library), *libraries]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        except FileNotFoundError:
            missing[name] = "g++ is missing"
            continue
        if done.returncode != 0:
            errors = [line for line in done.stderr.splitlines() if "error" in line]
            missing[name] = "does not compile: " + (errors or ["?"])[0].split("error: ")[-1]
            continue
        function = getattr(ctypes.CDLL(str(library)), f"{macro.lower()}_diagram")
        function.restype = ctypes.c_long
        function.argtypes = [ctypes.c_void_p, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
        scale = macro == "BOOST"
        methods[f"{name}, arrays"] = _native(function, arrays=True, scale=scale)
        methods[f"{name}, build"] = _native(function, arrays=False, scale=scale)
    return methods


def _native(function: Any, arrays: bool, scale: bool) -> Method:
    def run(sites: Sites) -> object:
        n = len(sites)
        if scale:
            sites = sites * (2.0**30 / np.abs(sites).max())
        if not arrays:
            return function(sites.ctypes.data, n, None, None)
        pairs, vertices = np.empty((3 * n, 2), dtype=np.int32), np.empty((2 * n, 2))
        count = function(sites.ctypes.data, n, pairs.ctypes.data, vertices.ctypes.data)
        return pairs[:count], vertices

    return run


def python_methods(missing: dict[str, str]) -> dict[str, Method]:
    methods: dict[str, Method] = {}

    def module(name: str, label: str) -> Any:
        try:
            return importlib.import_module(name)
        except ImportError:
            missing[label] = f"the module {name} is missing"
            return None

    if spatial := module("scipy.spatial", "SciPy (Qhull)"):
        methods["SciPy (Qhull) Delaunay, build"] = spatial.Delaunay
        methods["SciPy (Qhull) Voronoi, arrays"] = spatial.Voronoi
    if cv2 := module("cv2", "cv2.Subdiv2D"):
        cv2.setNumThreads(1)

        def subdivision(sites: Sites) -> object:
            low, high = sites.min() - 1.0, sites.max() + 2.0
            plane = cv2.Subdiv2D((int(low), int(low), int(high - low) + 1, int(high - low) + 1))
            plane.insert(sites.astype(np.float32))
            return plane

        methods["cv2.Subdiv2D, build"] = subdivision
    if pyvoronoi := module("pyvoronoi", "pyvoronoi (Boost)"):

        def boost(sites: Sites) -> object:
            diagram = pyvoronoi.Pyvoronoi(2.0**30 / np.abs(sites).max())
            for x, y in sites.tolist():
                diagram.AddPoint([x, y])
            diagram.Construct()
            return diagram

        methods["pyvoronoi (Boost), build"] = boost
    if triangle := module("triangle", "Triangle"):
        methods["Triangle, build"] = lambda sites: triangle.triangulate({"vertices": sites}, "")
    return methods


def measure(
    methods: dict[str, Method], make: Callable[[int, np.random.Generator], Sites], sizes: list[int]
) -> dict[str, dict[int, list[float]]]:
    """Seconds of CPU time per method and size, paired: run i of each method had the same input."""
    seconds: dict[str, dict[int, list[float]]] = {name: {} for name in methods}
    for n in sizes:
        rng = np.random.default_rng(n)
        left = {}
        for name in methods:
            known = [(m, statistics.median(t)) for m, t in seconds[name].items()]
            left[name] = not known or known[-1][1] * (n / known[-1][0]) ** 1.3 < SLOWEST_S
        repeats = int(np.clip(300_000 // n, 5, 60))
        for run in range(repeats + 1):
            sites = make(n, rng)
            names = list(methods)
            turn = run % len(names)  # whoever is first finds cold caches
            for name in names[turn:] + names[:turn]:
                if not left[name]:
                    continue
                method = methods[name]
                start = time.thread_time()
                method(sites)
                taken = time.thread_time() - start
                if run > 0:  # the first warms up
                    seconds[name].setdefault(n, []).append(taken)
                if taken > SLOWEST_S / 4 and run > 1:
                    left[name] = False
        print(f"{make.__name__} {n}: done", file=sys.stderr)
    return seconds


def table(
    title: str,
    seconds: dict[str, dict[int, list[float]]],
    sizes: list[int],
    missing: dict[str, str],
) -> list[str]:
    ours = next(iter(seconds.values()))
    heads = [f"{n:.0e}".replace("e+0", "e") for n in sizes]
    lines = [f"## {title}", "", "us a site, median (and time over ours, paired)", ""]
    lines += ["| | " + " | ".join(heads) + " | exponent |", "|---|" + "---|" * (len(sizes) + 1)]
    for name, by_size in seconds.items():
        row = []
        for n in sizes:
            if n not in by_size:
                row.append("-")
                continue
            each = by_size[n]
            ratio = statistics.median(t / o for t, o in zip(each, ours[n], strict=False))
            row.append(f"{statistics.median(each) / n * 1e6:.2f} ({ratio:.2f})")
        known = [n for n in sizes if n in by_size and n >= 1000]
        medians = [statistics.median(by_size[n]) for n in known]
        exponent = np.polyfit(np.log(known), np.log(medians), 1)[0] if len(known) > 1 else np.nan
        lines.append(f"| {name} | " + " | ".join(row) + f" | {exponent:.2f} |")
    lines += [f"| {name} | " + f"{why} |" + " |" * len(sizes) for name, why in missing.items()]
    return [*lines, ""]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--most", type=float, default=1e6, help="largest number of sites")
    parser.add_argument(
        "--output", type=Path, default=Path(__file__).parent / "results" / "voronoi.md"
    )
    options = parser.parse_args()
    sizes = [10**k for k in range(2, 7) if 10**k <= options.most]
    missing: dict[str, str] = {}
    methods: dict[str, Method] = {
        "**planner.delaunay.voronoi_diagram.voronoi_arrays, arrays**": voronoi_arrays,
        "**planner.voronoi, half-edges**": planner.voronoi,
        **native_methods(missing),
        **python_methods(missing),
    }
    lines = [
        "# Voronoi diagrams of points, side by side",
        "",
        "`python benchmarks/voronoi.py`; what is measured and how, its docstring says. "
        f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.machine()}, "
        "one thread, on a shared machine: compare within a table.",
        "",
    ]
    for title, make in (
        ("Uniform at random", random_sites),
        ("Along outlines, in outline order", outline_sites),
    ):
        lines += table(title, measure(methods, make, sizes), sizes, missing)
    text = "\n".join(lines)
    options.output.write_text(text)
    print(text)


if __name__ == "__main__":
    main()
