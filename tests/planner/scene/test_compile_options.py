"""Kernels that only borrow their arrays: nothing is counted in them, so nothing may be kept."""

import ast
import importlib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import njit, types
from numba.extending import is_jitted

import planner
from planner.formats.scene_text import read_scene_text
from planner.scene.compile_options import BORROWING

TOP = Path(planner.__file__).parents[1]
KERNELS = sorted(
    path for top in ("planner", "vision") for path in (TOP / top).rglob("*_kernels.py")
)
BORROW = "BORROWING", "LEAF", "SUMS"
"""The options of kernels that borrow."""
MAKERS = {
    *("arange", "argsort", "array", "ascontiguousarray", "bincount", "concatenate", "copy"),
    *("cumsum", "empty", "empty_like", "flatnonzero", "full", "linspace", "nonzero", "ones"),
    *("repeat", "sort", "stack", "unique", "where", "zeros", "zeros_like"),
}
SCENE = """
#@ bounds given 0 0 100 80
L 4 (20,20) (20,40) (40,40) (40,20)
C (70,50) 12
S (50,5) (60,20)
P (85,15)
"""


@cache
def _functions() -> dict[str, tuple[ast.FunctionDef, bool]]:
    """Every kernel by its dotted name: its code, and whether it borrows."""
    found = {}
    for path in KERNELS:
        module = ".".join(path.relative_to(TOP).with_suffix("").parts)
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.FunctionDef):
                text = " ".join(ast.unparse(d) for d in node.decorator_list)
                found[f"{module}.{node.name}"] = node, any(o in text for o in BORROW)
    return found


def _compiled(name: str) -> Any:
    module, function = name.rsplit(".", 1)
    return getattr(importlib.import_module(module), function)


def _called(name: str) -> set[str]:
    """What a kernel calls: kernels by their dotted names, all else by its last name."""
    around = _compiled(name).py_func.__globals__
    found = set()
    for call in ast.walk(_functions()[name][0]):
        if not isinstance(call, ast.Call):
            continue
        last = ast.unparse(call.func).rsplit(".", 1)[-1]
        kernel = around.get(last)
        if is_jitted(kernel):
            last = f"{kernel.py_func.__module__}.{kernel.py_func.__name__}"
        found.add(last)
    return found


def test_borrowing_kernels_make_no_arrays_and_call_their_like_only() -> None:
    borrowing = [name for name, (_, yes) in _functions().items() if yes]
    others = _functions().keys() - set(borrowing) | MAKERS
    wrong = [f"{name} calls {c}" for name in borrowing for c in _called(name) & others]
    assert len(borrowing) > 80
    assert not wrong


def _holds_an_array(kind: Any) -> bool:
    if isinstance(kind, types.BaseTuple):  # named ones too
        return any(map(_holds_an_array, kind.types))
    return not isinstance(kind, types.Number | types.Boolean | types.NoneType)


def test_borrowing_kernels_return_numbers() -> None:
    roadmap = planner.build_roadmap(read_scene_text(SCENE), 3.0)
    assert not isinstance(roadmap.plan((5, 5), (95, 75)), planner.NoPath)
    returned = {}
    for name, (_, yes) in _functions().items():
        if yes:
            for compiled in _compiled(name).overloads.values():
                returned[name] = compiled.signature.return_type
    # the cache keeps none of those that are only called inside others, and a test that ran before
    # in this process may have loaded more
    assert len(returned) >= 5
    assert not [name for name, kind in returned.items() if _holds_an_array(kind)]


@pytest.mark.parametrize(("options", "counted"), [(BORROWING, False), ({"nogil": True}, True)])
def test_nothing_is_counted_in_them(options: dict[str, Any], counted: bool) -> None:
    @njit(**{**options, "cache": False})
    def inner(a: Any, i: int) -> Any:
        return a[i] if a[i] > 0.0 else 1.0 + a[0]

    @njit(**{**options, "cache": False})
    def outer(a: Any) -> float:
        total = 0.0
        for i in range(len(a)):
            part = a if i % 2 else a[1:]
            if part[0] > total:
                total += inner(part, 0)
        return total

    assert outer(np.ones(4)) > 0.0
    code = "".join(outer.inspect_llvm().values())
    assert ("call void @NRT_incref" in code) == counted
