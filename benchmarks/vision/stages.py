"""What each stage of the fit of outlines earns: switched off alone, which figures fall.

Run ``python -m benchmarks.vision.stages [--count 12] [--only fillets,ends]``: per family of
``benchmarks.vision.grey_shapes`` with its blur and noise the shapes whose edges are not those that
were drawn, the mean number of edges and the rms distance of the outline from the truth; of drawings
without grey (``benchmarks.vision.cover``) those that cover less than 0.995, and how much the others
lack. First with all stages, then without each, as far as it makes a difference; at last a row a
stage, which is kept in ``docs/outlines.md`` where no stage is left out. The fit is compiled for
this: about two minutes.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import argparse
import math
import sys
import tempfile
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic
from scipy.spatial import cKDTree

from benchmarks.vision.compiled_again import compile_again
from benchmarks.vision.cover import KINDS, alike, outline
from benchmarks.vision.grey_shapes import FAMILIES, SEED, drawn
from planner.scene import Arc, PolygonRecord, object_records
from planner.scene.compile_options import LEAF
from tests.support.drawn.outline_judge import record_points
from tests.support.drawn.render import centers_inside, outline_points
from vision import extract
from vision.outline import fitting_kernels, partition_kernels, whole_circle_kernels
from vision.outline.bilevel import merged_edge_kernels
from vision.outline.check import area_lost_kernels
from vision.outline.corners import edit_kernels, edit_search_kernels, joint_kernels

FARTHER_BY = 1.02
"""What makes a difference: one more wrong shape, or so many times the distance."""
Figures = dict[str, tuple[int, float, float]]
STAGES = (
    "corners",
    "lines",
    "ends",
    "fillets",
    "touching",
    "squaring",
    "missed arcs",
    "seeds moved to corners",
    "a second start",
    "fits between the pixels",
    "joints relaxed",
    "runs merged",
)
"""What is switched off; the first four are the edits, by their numbers."""
OFF = np.zeros(len(STAGES), np.int64)
"""Which stages are: kernels read it where it lies, so that they are compiled once."""
TOUCHING, SQUARING, MISSED, SNAPPING, START, FITS, RELAXING, MERGING = range(4, len(STAGES))
STEPS: tuple[tuple[int, ModuleType, str], ...] = (
    (TOUCHING, edit_search_kernels, "touch_lines"),
    (SQUARING, edit_search_kernels, "square_ends"),
    (SNAPPING, partition_kernels, "snap_seeds"),
    (FITS, joint_kernels, "separate_line"),
    (FITS, joint_kernels, "separate_circle"),
    (FITS, partition_kernels, "separate_circle"),
    (FITS, whole_circle_kernels, "separate_circle"),
    (FITS, merged_edge_kernels, "separate_circle"),
    (RELAXING, area_lost_kernels, "relax_joints"),
)
"""The steps of stages that give nothing back, and where they are called."""
CORNERED = 10.0
"""A turn that is a corner whatever the limit, radians."""


@intrinsic
def is_off(typing: Any, stage: Any) -> Any:
    """Whether a stage is switched off just now."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        whole = ir.IntType(64)
        begin = builder.inttoptr(ir.Constant(whole, OFF.ctypes.data), whole.as_pointer())
        found = builder.load(builder.gep(begin, [values[0]]))
        return builder.icmp_signed("!=", found, ir.Constant(whole, 0))

    return types.boolean(types.int64), generate


def optional(stage: int, step: Any) -> Any:
    """A step that gives nothing back, unless its stage is switched off."""

    @njit(**LEAF)
    def taken(*given):
        if not is_off(stage):
            step(*given)

    return taken


def make_optional(folder: str) -> None:
    """Let every stage look whether it is switched off, before anything of it is compiled.

    ``folder``: an empty one for what is compiled.
    """
    compile_again("vision.outline.", folder)
    may_be: Any = edit_kernels._may_be
    any_bent, turn_at = fitting_kernels.any_bent_line, partition_kernels.turn_at
    merge: Any = fitting_kernels.merge_edges

    @njit(**LEAF)
    def edits(border, outline, edges, run, kind, line_price, blur, stays):
        if is_off(kind):
            return False
        return may_be(border, outline, edges, run, kind, line_price, blur, stays)

    @njit(**LEAF)
    def missed_arcs(border, outline, edges, spread, scratch):
        return not is_off(MISSED) and any_bent(border, outline, edges, spread, scratch)

    @njit(**LEAF)
    def turning(border, k, reach):
        return turn_at(border, k, reach) + (CORNERED if is_off(START) else 0.0)

    @njit(**LEAF)
    def merging(cracks, finished, count, one_circle, trial, circle, scratch):
        if is_off(MERGING):
            return count
        return merge(cracks, finished, count, one_circle, trial, circle, scratch)

    edit_kernels._may_be, fitting_kernels.merge_edges = edits, merging
    fitting_kernels.any_bent_line, partition_kernels.turn_at = missed_arcs, turning
    for stage, module, name in STEPS:
        vars(module)[name] = optional(stage, vars(module)[name])


DRAWN = "drawn "
"""How the cells of pictures without grey begin."""
PAGE = Path(__file__).parents[2] / "docs" / "outlines.md"
BEGIN, END = "<!-- benchmarks.vision.stages -->\n", "<!-- end -->\n"
"""What the kept table stands between."""


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
    for kind in KINDS:
        found[DRAWN + kind] = drawn_figures(kind, count)
    return found


def drawn_figures(kind: str, count: int) -> tuple[int, float, float]:
    """The same of drawings without grey: the distance is what their cover lacks, in percent."""
    wrong, edges, lacks = 0, [], []
    for i in range(count):
        mask = outline(np.random.default_rng([SEED, i, len(kind)]), kind)
        picture = np.where(mask, 0, 255).astype(np.uint8)
        records = [r for o in extract(picture).objects for r in object_records(o)]
        again = centers_inside([outline_points(r) for r in records], (200, 200))
        overlap = alike(mask, again)[0]
        wrong += overlap < 0.995
        edges.append(sum(len(r.edges) if isinstance(r, PolygonRecord) else 1 for r in records))
        lacks.append(100.0 * (1.0 - overlap))
    return wrong, float(np.mean(edges)), float(np.mean(lacks))


def row(cell: str, figure: tuple[int, float, float]) -> str:
    return f"| {cell} | {figure[0]} | {figure[1]:.2f} | {figure[2]:.3f} |"


def differs(now: tuple[int, float, float], was: tuple[int, float, float]) -> bool:
    """Whether figures are others by one wrong shape, or by ``FARTHER_BY``."""
    ratios = [max(a, 1e-9) / max(b, 1e-9) for a, b in zip(now[1:], was[1:], strict=True)]
    return now[0] != was[0] or any(abs(math.log(r)) > math.log(FARTHER_BY) for r in ratios)


def summary(stage: str, figures: Figures, usual: Figures) -> str:
    """A stage's row: wrong shapes, edges and distances in all, and the cells that differ most."""

    def sums(some: Figures) -> str:
        grey = [one for cell, one in some.items() if not cell.startswith(DRAWN)]
        flat = [one for cell, one in some.items() if cell.startswith(DRAWN)]
        rms = math.sqrt(float(np.mean(np.square([one[2] for one in grey]))))
        return (
            f"{sum(one[0] for one in grey)} | {np.mean([one[1] for one in grey]):.2f} | {rms:.4f} "
            f"| {np.mean([one[1] for one in flat]):.2f} | {np.mean([one[2] for one in flat]):.3f}"
        )

    worse = {cell: now[0] - usual[cell][0] for cell, now in figures.items()}
    most = sorted((cell for cell, more in worse.items() if more > 0), key=lambda c: -worse[c])[:3]
    said = ", ".join(f"{cell} {usual[cell][0]} to {figures[cell][0]}" for cell in most)
    return f"| {stage} | {sums(figures)} | {said} |"


def keep(rows: list[str], count: int) -> None:
    """Write the stages' rows into the page on outlines."""
    head = (
        "| switched off | wrong edges | edges, mean | rms px | drawn: edges, mean "
        "| not covered, % | most wrong |\n|---|---|---|---|---|---|---|"
    )
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    behind = rest.split(END)[1]
    table = "\n".join((f"{count} shapes a cell.\n", head, *rows))
    PAGE.write_text(f"{before}{BEGIN}{table}\n{END}{behind}", encoding="utf-8")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=12, help="shapes a cell")
    parser.add_argument("--only", default="", help="stages, separated by commas")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        make_optional(folder)
        compare(given.only.split(",") if given.only else [], given.count)
    return 0


def compare(only: list[str], count: int) -> None:
    """Print the figures with all stages and without each; keep them where all are compared."""
    usual = figures(count)
    head = "| blur / noise | wrong | edges, mean | rms px |\n|---|---|---|---|"
    print(f"## all stages\n\n{count} shapes a cell.\n\n{head}")
    print("\n".join(row(cell, figure) for cell, figure in usual.items()), flush=True)
    rows = [summary("nothing", usual, usual)]
    for stage in only or STAGES:
        print(f"\n## without {stage}\n\n{head}")
        OFF[STAGES.index(stage)] = 1
        without = figures(count)
        OFF[:] = 0
        for cell, figure in without.items():
            if differs(figure, usual[cell]):
                print(row(cell, figure), flush=True)
        rows.append(summary(stage, without, usual))
    print("\n" + "\n".join(rows))
    if not only:
        keep(rows, count)


if __name__ == "__main__":
    sys.exit(main())
