"""What each stage of the fit of grey outlines earns: switched off alone, which figures fall.

Run ``python -m benchmarks.vision.stages [--count 40] [--only fillets,ends]``: per family of
``benchmarks.vision.grey_shapes`` and per blur and noise the shapes whose edges are not those that
were drawn, the mean number of edges and the rms distance of the outline from the truth; first with
all stages, then without each, as far as it makes a difference. Each stage takes a process of its
own, since the fit has to be compiled without it: about half a minute.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numba import njit
from numba.core.caching import NullCache
from scipy.spatial import cKDTree

from benchmarks.vision.grey_shapes import FAMILIES, drawn
from planner.scene import Arc, PolygonRecord, object_records
from planner.scene.compile_options import LEAF
from tests.support.drawn.outline_judge import record_points
from vision import extract
from vision.outline import fitting_kernels
from vision.outline.corners import edit_kernels, edit_search_kernels

FARTHER_BY = 1.02
"""What makes a difference: one more wrong shape, or so many times the distance."""
Figures = dict[str, tuple[int, float, float]]


def replace(module: ModuleType, **stages: object) -> None:
    """Let names of a module mean others, before anything of it is compiled."""
    vars(module).update(stages)


def without_edits(kind: int) -> Callable[[], None]:
    """Let no edit of a kind be looked at."""

    def switch_off() -> None:
        inner: Any = edit_kernels._may_be

        @njit(**LEAF)
        def may_be(border, outline, edges, run, this, line_price, blur, stays):
            if this == kind:
                return False
            return inner(border, outline, edges, run, this, line_price, blur, stays)

        edit_kernels._may_be = may_be

    return switch_off


def without_touching() -> None:
    @njit(**LEAF)
    def nothing(border, outline, edges, blur, costs, change):
        return None

    replace(edit_search_kernels, touch_lines=nothing)


def without_squaring() -> None:
    @njit(**LEAF)
    def nothing(outline, edges, blur):
        return None

    replace(edit_search_kernels, square_ends=nothing)


def without_missed_arcs() -> None:
    @njit(**LEAF)
    def never(border, outline, edges, spread, circle):
        return False

    replace(fitting_kernels, any_bent_line=never)


def without_second_search() -> None:
    fitting_kernels.LOOKS = 1


STAGES: dict[str, Callable[[], None]] = {
    "corners": without_edits(int(edit_kernels.CORNER)),
    "lines": without_edits(int(edit_kernels.LINE)),
    "ends": without_edits(int(edit_kernels.END)),
    "fillets": without_edits(int(edit_kernels.FILLET)),
    "touching": without_touching,
    "squaring": without_squaring,
    "missed arcs": without_missed_arcs,
    "second search": without_second_search,
}


def figures(count: int) -> Figures:
    """Per cell the wrong shapes, the mean number of edges and the rms distance in pixels."""
    found: Figures = {}
    for name, family in FAMILIES.items():
        for look in family.looks:
            wrong, edges, squares = 0, [], []
            for i in range(count):
                truth, picture = drawn(name, look, i)
                records = [r for o in extract(picture).objects for r in object_records(o)]
                ours = [e for r in records if isinstance(r, PolygonRecord) for e in r.edges]
                arcs = [sum(isinstance(e, Arc) for e in these) for these in (ours, truth.edges)]
                wrong += family.has_edges and (len(ours), arcs[0]) != (len(truth.edges), arcs[1])
                edges.append(len(ours))
                a, b = np.concatenate([record_points(r) for r in records]), record_points(truth)
                pairs = ((a, b), (b, a))
                squares.append(max(np.square(cKDTree(p).query(q)[0]).mean() for p, q in pairs))
            cell = f"{name} {look[0]} / {look[1]:.0f}"
            found[cell] = wrong, float(np.mean(edges)), math.sqrt(float(np.mean(squares)))
    return found


def figures_without(stage: str, count: int) -> Figures:
    """The figures without a stage, from a process of its own."""
    command = [sys.executable, "-m", "benchmarks.vision.stages", "--count", str(count)]
    here = Path(__file__).parents[2]
    done = subprocess.run(
        [*command, "--without", stage], capture_output=True, text=True, check=True, cwd=here
    )
    return {name: tuple(row) for name, row in json.loads(done.stdout).items()}


def row(cell: str, figure: tuple[int, float, float]) -> str:
    return f"| {cell} | {figure[0]} | {figure[1]:.2f} | {figure[2]:.3f} |"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=40, help="shapes a cell")
    parser.add_argument("--only", default="", help="stages, separated by commas")
    parser.add_argument("--without", default="", help="print the figures without one stage")
    given = parser.parse_args()
    if given.without:
        STAGES[given.without]()
        for kernel in (fitting_kernels.fit_borders, edit_kernels.find_edits):
            kernel._cache = NullCache()
        print(json.dumps(figures(given.count)))
        return 0
    usual = figures(given.count)
    head = "| blur / noise | wrong | edges, mean | rms px |\n|---|---|---|---|"
    print(f"## all stages\n\n{given.count} shapes a cell.\n\n{head}")
    print("\n".join(row(cell, figure) for cell, figure in usual.items()), flush=True)
    for stage in given.only.split(",") if given.only else STAGES:
        print(f"\n## without {stage}\n\n{head}")
        for cell, figure in figures_without(stage, given.count).items():
            was = usual[cell]
            if figure[0] != was[0] or abs(math.log(figure[2] / was[2])) > math.log(FARTHER_BY):
                print(row(cell, figure), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
