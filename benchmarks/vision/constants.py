"""What every tuned constant of the fit of outlines earns: halved and doubled, which figures change.

Run ``python -m benchmarks.vision.constants [--count 12] [--only SNAP,CORNER]``: a row for each one
of ``vision/outline/*_kernels.py`` whose docstring calls it chosen or measured. For the pictures of
``benchmarks.vision.stages``, with grey and without: how many more outlines are wrong, how many more
edges they have in the mean, and by how much farther off they are. Where neither half nor double
changes a figure, the mechanism does nothing or only spares work. The kernels are compiled once, for
numbers that they read where they lie: about two minutes, and a second a shape a cell for each.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import argparse
import ast
import importlib.abc
import importlib.machinery
import os
import sys
from collections.abc import Callable
from pathlib import Path, PurePosixPath
from types import CodeType, ModuleType
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import types
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
Figure = tuple[int, float, float]


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
        tuned = {one.name for one in named_numbers([file]) if one.tuned}
        known: dict[str, str] = {}
        body = [n for n in tree.body if not isinstance(n, ast.FunctionDef) or not n.decorator_list]
        exec(self._compiled(body), values)
        for node in body:
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(PACKAGE):
                for alias in node.names:
                    key = f"{node.module}.{alias.name}"
                    if key in PLACES or f"{key}[0]" in PLACES:
                        known[alias.name] = key
        for name in sorted(tuned):
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


def row(key: str, count: int, figures: Callable[[int], dict[str, Figure]], usual: Any) -> str:
    """A constant's row: its value, and what half and double of it change."""
    numbers, at = PLACES[key]
    value = numbers[at].copy()
    told = []
    for other in (value / 2, value * 2):
        numbers[at] = max(other, 1) if numbers is WHOLES else other
        told.append(change(usual, figures(count)))
    numbers[at] = value
    return f"| {key.removeprefix(PACKAGE)} | {value:g} | {told[0]} | {told[1]} |"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=12, help="shapes a cell")
    parser.add_argument("--only", default="", help="names, separated by commas")
    given = parser.parse_args()
    sys.meta_path.insert(0, _Finder())
    from benchmarks.vision.stages import figures

    usual = figures(given.count)
    print("| constant | value | half | double |\n|---|---|---|---|")
    for key in sorted(PLACES):
        name = key.rsplit(".", 1)[1].split("[")[0]
        if given.only and name not in given.only.split(","):
            continue
        # in a process of its own: a number that is out of bounds may end it
        if os.fork() == 0:
            print(row(key, given.count, figures, usual), flush=True)
            os._exit(0)
        os.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
