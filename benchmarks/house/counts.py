"""What one file after the other shows: long functions, crowded folders.

Each function returns a sentence for everything that goes beyond the limit, in the files' order.
A kernel is a function under a decorator of numba's (``njit`` or ``jit``). A function's length is
from its ``def`` to its last line, with the docstring and without the decorators.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterable

from benchmarks.house.tree import File, Function


def is_kernel(function: Function) -> bool:
    for decorator in function.decorator_list:
        called = decorator.func if isinstance(decorator, ast.Call) else decorator
        name = called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")
        if name in ("njit", "jit"):
            return True
    return False


def long_functions(files: Iterable[File], limit: int) -> list[str]:
    found = []
    for file in files:
        for function in file.functions():
            assert function.end_lineno is not None
            lines = function.end_lineno - function.lineno + 1
            if lines > limit:
                found.append(f"{file.path}:{function.lineno}: {function.name} has {lines} lines")
    return found


def crowded_folders(files: Iterable[File], limit: int) -> list[str]:
    crowd = Counter(file.path.parent for file in files)
    return [f"{folder}: {count} Python files" for folder, count in crowd.items() if count > limit]


def long_files(files: Iterable[File], limit: int) -> list[str]:
    return [f"{file.path}: {file.lines} lines" for file in files if file.lines > limit]


def short_kernel_files(files: Iterable[File], limit: int) -> list[str]:
    """Files below the limit that hold a kernel: candidates for a split made for a cache only."""
    return [
        f"{file.path}: {file.lines} lines"
        for file in files
        if not file.is_init
        and file.lines < limit
        and any(is_kernel(function) for function in file.functions())
    ]
