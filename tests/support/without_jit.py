"""The same program with the compiler and without: kernels are their own reference."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
AGREES = 1e-6
"""Compiled sums may be added up in another order; in units of the picture or the scene."""


def printed_by(program: str, *, compiled: bool) -> str:
    """What a program prints in a Python of its own."""
    off = "0" if compiled else "1"
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "NUMBA_DISABLE_JIT": off, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def differences(a: Any, b: Any, where: str = "") -> list[str]:
    """Where two answers read from JSON differ by more than rounding."""
    if isinstance(a, dict) and isinstance(b, dict) and a.keys() == b.keys():
        return [line for key in a for line in differences(a[key], b[key], f"{where}.{key}")]
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        pairs = enumerate(zip(a, b, strict=True))
        return [line for i, (x, y) in pairs for line in differences(x, y, f"{where}[{i}]")]
    if isinstance(a, float) and isinstance(b, float):
        alike = math.isclose(a, b, rel_tol=AGREES, abs_tol=AGREES)
    else:
        alike = a == b
    return [] if alike else [f"{where}: {a} and {b}"]


def answers_differ(program: str) -> list[str]:
    """Run a program that prints JSON both ways; what differs."""
    compiled = json.loads(printed_by(program, compiled=True))
    plain = json.loads(printed_by(program, compiled=False))
    return differences(compiled, plain)
