"""What one file after the other shows: long functions, wide kernels, crowded folders.

Each function returns a sentence for everything that goes beyond the limit, in the files' order.
A kernel is a function under a decorator of numba's (``njit`` or ``jit``). A function's length is
from its ``def`` to its last line, with the docstring and without the decorators.
"""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from benchmarks.house.tree import File, Function

REASON = re.compile(r"#\s*noqa:\s*C901\s*(?:[-:#(]\s*)?(\w.{9,})")
"""An exemption from the limit on complexity, with a reason of ten letters at least."""


def is_kernel(function: Function) -> bool:
    for decorator in function.decorator_list:
        called = decorator.func if isinstance(decorator, ast.Call) else decorator
        name = called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")
        if name in ("njit", "jit"):
            return True
    return False


def parameters(function: Function) -> int:
    given = function.args
    several = (given.vararg, given.kwarg)
    alone = len(given.posonlyargs) + len(given.args) + len(given.kwonlyargs)
    return alone + sum(one is not None for one in several)


def wide_kernels(files: Iterable[File], limit: int) -> list[str]:
    return [
        f"{file.path}:{function.lineno}: {function.name} takes {parameters(function)} parameters"
        for file in files
        for function in file.functions()
        if is_kernel(function) and parameters(function) > limit
    ]


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


def complex_functions(root: Path, folders: Sequence[str], limit: int) -> list[str]:
    """Functions that ruff calls too complex, but for those whose exemption names its reason."""
    command = [
        *(sys.executable, "-m", "ruff", "check", "--isolated", "--no-cache", "--ignore-noqa"),
        *("--select", "C901", "--config", f"lint.mccabe.max-complexity={limit}"),
        *("--output-format", "json", "--exit-zero", *folders),
    ]
    answer = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True)
    found = []
    for one in json.loads(answer.stdout):
        path = Path(one["filename"])
        row = one["location"]["row"]
        if not REASON.search(path.read_text(encoding="utf-8").splitlines()[row - 1]):
            inside = path.relative_to(root.resolve()).as_posix()
            found.append(f"{inside}:{row}: {one['message']}")
    return sorted(found)
