"""Corners, circles, arcs, cover, counts and speed of the extractor beside OpenCV, with truth.

Run ``python -m benchmarks.vision [--count 200] [--only corners,speed] [--cells 0.7/20,8]``: prints
the tables and keeps them in ``benchmarks/results/vision.md``, section by section: what is not
run stays as it was. ``--cells`` keeps the rows whose first column begins so, and is not kept.
Seeds are in the file. Times are processor time, the least of several interleaved runs on one
thread; they vary from machine to machine: compare the ratios.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from pathlib import Path

import cv2

from benchmarks.vision.corners import corner_table
from benchmarks.vision.counts import count_table, ramp_table
from benchmarks.vision.cover import cover_table
from benchmarks.vision.regions import region_table
from benchmarks.vision.rounds import arc_table, circle_table, stepped_table
from benchmarks.vision.speed import speed_table


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
        "stepped": lambda: stepped_table(count, cells),
        "arcs": lambda: arc_table(count, cells),
        "cover": lambda: cover_table(count, cells),
        "counts": lambda: count_table(count, cells),
        "ramps": lambda: ramp_table(count, cells),
        "regions": lambda: region_table(count, cells),
        "speed": lambda: speed_table(cells),
    }
    results = Path(__file__).parents[1] / "results" / "vision.md"
    results.parent.mkdir(exist_ok=True)
    asked = [one for one in options.only.split(",") if one] or list(tables)
    for name in asked:
        table = f"{count} scenes a cell.\n\n" if name not in ("ramps", "stepped", "speed") else ""
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
