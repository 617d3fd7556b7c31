"""How much every number of the fit of outlines matters: halved and doubled, which outlines change.

Run ``python -m benchmarks.vision.constants [--count 4] [--only SNAP,CORNER] [--figures]``: a row
for each one of ``vision/outline`` that is no tuple and whose docstring calls it chosen, measured or
indifferent: how many of all pictures have another outline, by whatever little. The pictures are
those of ``benchmarks.vision.stages`` with grey and without, small drawn shapes, discs with blurred
steps, and the real shapes below ``CLEARWAY_REAL_DATA`` where that is
set. With ``--figures`` also how many more outlines are wrong, how many more edges they have in the
mean, and by how much farther off they are. A number that is called indifferent and is not ends the
run with 1. The kernels are compiled once, for numbers that they read where they lie: about two
minutes.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import argparse
import ast
import importlib.abc
import importlib.machinery
import math
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path, PurePosixPath
from types import CodeType, ModuleType
from typing import Any

import cv2
import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

import planner.scene.compile_options as options
from benchmarks.house.constants import named_numbers
from benchmarks.house.tree import File

ROOT = Path(__file__).parents[2]
PACKAGE = "vision.outline."
REALS, WHOLES = np.zeros(500), np.zeros(500, np.int64)
"""Where the numbers lie."""
PLACES: dict[str, tuple[np.ndarray, int]] = {}
"""Of each ``module.NAME`` (``module.NAME[i]``): in which of both arrays, and where."""
PLAIN: dict[str, ModuleType] = {}
"""Of each ``module.NAME`` that no kernel reads: its module."""
Figure = tuple[int, float, float]
FREE = "indifferent"
FREE_ONES: set[str] = set()
"""Those that are called so."""
REAL_PX = 1_000_000
SMALL = (2, 3, 4, 6, 9, 13, 20)
"""Radii of small shapes, pixels."""


def _reader(numbers: np.ndarray, real: bool) -> Any:
    """A kernel that reads a number where it lies."""

    @intrinsic
    def read(typing: Any, index: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            whole = ir.IntType(64)
            kind = ir.DoubleType() if real else whole
            begin = builder.inttoptr(ir.Constant(whole, numbers.ctypes.data), kind.as_pointer())
            return builder.load(builder.gep(begin, [values[0]]))

        return (types.float64 if real else types.int64)(types.int64), generate

    return read


READERS = {"_read_real": _reader(REALS, True), "_read_whole": _reader(WHOLES, False)}


def number(key: str) -> float:
    """A number's value."""
    if key in PLAIN:
        found: float = vars(PLAIN[key])[key.rsplit(".", 1)[1]]
        return found
    numbers, at = PLACES[key]
    return float(numbers[at]) if numbers is REALS else int(numbers[at])


def set_number(key: str, value: float) -> None:
    """Let a number have another value, whole where it is."""
    whole = isinstance(number(key), int)
    value = max(int(value), 1) if whole else value
    if key not in PLAIN:
        numbers, at = PLACES[key]
        numbers[at] = value
        return
    name, old = key.rsplit(".", 1)[1], number(key)
    for module in [m for n, m in sys.modules.items() if n.startswith("vision.outline")]:
        if getattr(module, name, None) is old:
            setattr(module, name, value)


def find_plain() -> None:
    """The numbers of the modules that are no kernels."""
    for path in sorted((ROOT / "vision" / "outline").rglob("*.py")):
        place = PurePosixPath(path.relative_to(ROOT))
        if place.stem.endswith("_kernels") or place.stem == "__init__":
            continue
        text = path.read_text(encoding="utf-8")
        file = File(place, text, ast.parse(text))
        for one in named_numbers([file]):
            module, key = importlib.import_module(file.module), f"{file.module}.{one.name}"
            if one.source == FREE:
                FREE_ONES.add(key)
            if (one.tuned or key in FREE_ONES) and isinstance(vars(module)[one.name], int | float):
                PLAIN[key] = module


class _Reading(ast.NodeTransformer):
    """In kernels, names of constants become readings of them."""

    def __init__(self, known: dict[str, str]) -> None:
        self.known = known
        self.inside = False

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        if any("njit" in ast.dump(one) for one in node.decorator_list):
            self.inside = True
            node.body = [self.visit(one) for one in node.body]
            self.inside = False
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        if self.inside and isinstance(node.value, ast.Name) and node.value.id in self.known:
            return self._call(node.value.id, node.slice)
        return self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> ast.AST:
        if self.inside and node.id in self.known and isinstance(node.ctx, ast.Load):
            return self._call(node.id, None)
        return node

    def _call(self, name: str, index: ast.expr | None) -> ast.Call:
        key = self.known[name]
        numbers, at = PLACES[key if key in PLACES else f"{key}[0]"]
        where: ast.expr = ast.Constant(at)
        if index is not None:
            where = ast.BinOp(where, ast.Add(), index)
        reader = "_read_real" if numbers is REALS else "_read_whole"
        return ast.Call(ast.Name(reader, ast.Load()), [where], [])


class _Loader(importlib.machinery.SourceFileLoader):
    """Loads a module of kernels so that they read their constants; what it compiles is not kept."""

    def exec_module(self, module: ModuleType) -> None:
        text = Path(self.path).read_text(encoding="utf-8")
        tree = ast.parse(text)
        values = module.__dict__
        file = File(PurePosixPath(self.path).relative_to(ROOT), text, tree)
        tuned = {one.name for one in named_numbers([file]) if one.tuned or one.source == FREE}
        FREE_ONES.update(
            f"{module.__name__}.{n.name}" for n in named_numbers([file]) if n.source == FREE
        )
        known: dict[str, str] = {}
        body = [n for n in tree.body if not isinstance(n, ast.FunctionDef) or not n.decorator_list]
        exec(self._compiled(body), values)
        for node in body:
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(PACKAGE):
                for alias in node.names:
                    key = f"{node.module}.{alias.name}"
                    if key in PLACES or f"{key}[0]" in PLACES:
                        known[alias.name] = key
        gone_through = {
            one.iter.id
            for one in ast.walk(tree)
            if isinstance(one, ast.For) and isinstance(one.iter, ast.Name)
        }
        for name in sorted(tuned - gone_through):
            key = f"{module.__name__}.{name}"
            self._place(key, values[name])
            known[name] = key
        values.update(READERS)
        kernels = [n for n in tree.body if n not in body]
        for one in kernels:
            ast.fix_missing_locations(_Reading(known).visit(one))
        kinds = (options.OWNING, options.BORROWING, options.LEAF, options.SUMS)
        for kind in kinds:
            kind["cache"] = False
        exec(self._compiled(kernels), values)
        for kind in kinds:
            kind["cache"] = True

    def _compiled(self, body: list[Any]) -> CodeType:
        return compile(ast.Module(body, []), self.path, "exec")

    def _place(self, key: str, value: Any) -> None:
        parts = value if isinstance(value, tuple) else (value,)
        numbers = REALS if isinstance(parts[0], float) else WHOLES
        for i, part in enumerate(parts):
            at = sum(1 for n, _ in PLACES.values() if n is numbers)
            numbers[at] = part
            PLACES[key if len(parts) == 1 else f"{key}[{i}]"] = numbers, at


class _Finder(importlib.abc.MetaPathFinder):
    """Finds the modules of kernels of the outlines, for ``_Loader``."""

    def find_spec(self, name: str, path: Any, target: Any = None) -> Any:
        if not (name.startswith(PACKAGE) and name.endswith("_kernels")):
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path)
        if spec is not None and spec.origin is not None:
            spec.loader = _Loader(name, spec.origin)
        return spec


def change(before: dict[str, Figure], now: dict[str, Figure]) -> str:
    """What has become of the figures, grey and drawn apart; "nothing" where all are as before."""
    said = []
    for group in ("grey", "drawn"):
        cells = [cell for cell in before if cell.startswith("drawn ") == (group == "drawn")]
        if all(now[cell] == before[cell] for cell in cells):
            continue
        wrong = sum(now[cell][0] - before[cell][0] for cell in cells)
        edges = np.mean([now[cell][1] - before[cell][1] for cell in cells])
        off = [np.mean([some[cell][2] for cell in cells]) for some in (now, before)]
        said.append(f"{group}: {wrong:+d} wrong, {edges:+.2f} edges, {off[0] / off[1] - 1:+.1%}")
    return "; ".join(said) or "nothing"


def pictures(count: int) -> list[np.ndarray]:
    """Pictures with and without grey, made and real."""
    from benchmarks.vision.cover import KINDS, outline
    from benchmarks.vision.grey_shapes import FAMILIES, SEED, drawn
    from benchmarks.vision.rounds import stepped_disc

    grey = [
        drawn(name, look, i)[1]
        for name, family in FAMILIES.items()
        for look in family.looks
        for i in range(count)
    ]
    crisp = [
        _black_and_white(outline(np.random.default_rng([SEED, i, len(kind)]), kind))
        for kind in KINDS
        for i in range(count)
    ]
    stepped = [
        stepped_disc(radius, blur, noise, np.random.default_rng([SEED, radius, int(noise)]))
        for radius in SMALL[3:]
        for blur in (0.7, 1.5)
        for noise in (0.0, 4.0)
    ]
    return [*grey, *crisp, *stepped, *_small(count), *_real()]


def _small(count: int) -> Iterator[np.ndarray]:
    """Crisp discs, squares and half discs, turned by chance."""
    rng = np.random.default_rng(5)
    for radius in SMALL:
        for _ in range(count):
            y, x = np.mgrid[0:60, 0:60] - 30.0 + rng.uniform(-0.5, 0.5, 2)[:, None, None]
            turn = rng.uniform(0.0, math.tau)
            u = x * math.cos(turn) + y * math.sin(turn)
            v = y * math.cos(turn) - x * math.sin(turn)
            round_one = np.hypot(u, v) <= radius
            for mask in (round_one, np.maximum(abs(u), abs(v)) <= radius, round_one & (v >= 0)):
                yield _black_and_white(mask)


def _black_and_white(mask: np.ndarray) -> np.ndarray:
    return np.where(mask, 25, 235).astype(np.uint8)


def _real() -> Iterator[np.ndarray]:
    data = os.environ.get("CLEARWAY_REAL_DATA")
    for file in sorted(Path(data, "shapes").rglob("*.png")) if data else ():
        picture = cv2.imread(str(file))
        if picture is not None and picture.shape[0] * picture.shape[1] <= REAL_PX:
            yield picture


def outlines(shown: list[np.ndarray]) -> list[str]:
    """Of each picture its outlines as text, or why there are none."""
    from vision import PictureError, extract

    found = []
    for picture in shown:
        try:
            found.append(repr(extract(picture).objects))
        except PictureError as error:
            found.append(str(error))
    return found


def row(key: str, differences: Callable[[], list[str]]) -> tuple[str, bool]:
    """A constant's row: what half and double of it change; and whether no outline is another."""
    value = number(key)
    cells = []
    for other in (value / 2, value * 2):
        set_number(key, other)
        cells.append(differences())
        set_number(key, value)
    both = [cell for pair in zip(*cells, strict=True) for cell in pair]
    line = " | ".join([key.removeprefix(PACKAGE), f"{value:g}", *both])
    return f"| {line} |", both[:2] == ["0", "0"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=4, help="shapes a cell")
    parser.add_argument("--only", default="", help="names, separated by commas")
    parser.add_argument("--figures", action="store_true", help="of the stages, too")
    given = parser.parse_args()
    sys.meta_path.insert(0, _Finder())
    from benchmarks.vision.stages import figures

    shown = pictures(given.count)
    usual, before = outlines(shown), figures(given.count) if given.figures else {}

    def differences() -> list[str]:
        others = sum(a != b for a, b in zip(outlines(shown), usual, strict=True))
        return [str(others), *([change(before, figures(given.count))] if given.figures else [])]

    more = " figures, half | double |" if given.figures else ""
    print(f"{len(shown)} pictures.\n\n| number | value | other outlines, half | double |{more}")
    print("|---" * (4 + 2 * given.figures) + "|", flush=True)
    wrong = 0
    find_plain()
    for key in sorted({*PLACES, *PLAIN}):
        name = key.rsplit(".", 1)[1].split("[")[0]
        if given.only and name not in given.only.split(","):
            continue
        # in a process of its own: a number that is out of bounds may end it
        child = os.fork()
        if child == 0:
            line, same = row(key, differences)
            print(line, flush=True)
            os._exit(0 if same or key.split("[")[0] not in FREE_ONES else 3)
        _, status = os.waitpid(child, 0)
        if os.waitstatus_to_exitcode(status) == 3:
            print(f"{key} is called indifferent, and is not", file=sys.stderr)
            wrong = 1
    return wrong


if __name__ == "__main__":
    sys.exit(main())
