"""Processor that kernels are compiled for: the most common one that this machine contains.

A kernel compiled for the very processor at hand is useless on another one, and could not be
shipped. The levels of x86-64 are those of the psABI: every processor since 2009 has v2, and since
2013 to 2015 v3 (AVX2, FMA). There is one level for 64-bit ARM: every processor has NEON.
"""

from __future__ import annotations

import platform
from collections.abc import MutableMapping
from pathlib import Path
from typing import Any

import numba
from numba.core.registry import cpu_target

LEVELS = {
    "x86-64-v3": frozenset(["avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe"]),
    "x86-64-v2": frozenset(["cx16", "lahf_lm", "popcnt", "pni", "sse4_1", "sse4_2", "ssse3"]),
}
"""The flags of /proc/cpuinfo that each level adds to the one below, the highest level first."""
COMMON_ARM = "generic"
"""LLVM's name for ARMv8-A without extensions."""


def common_processor(machine: str, cpuinfo: str) -> str | None:
    """LLVM's name for a machine's highest common level, or None.

    ``machine`` is the result of ``platform.machine()``, ``cpuinfo`` the text of /proc/cpuinfo.
    """
    if machine in ("aarch64", "arm64"):
        return COMMON_ARM
    if machine not in ("x86_64", "AMD64"):
        return None
    has = _flags(cpuinfo)
    level = None
    for name, flags in reversed(LEVELS.items()):
        if not flags <= has:
            break
        level = name
    return level


def choose_processor(environment: MutableMapping[str, str]) -> str | None:
    """Make numba compile for the common processor, unless the user has named another.

    Takes effect only if numba has defined no kernel yet, even in someone else's program. Returns
    the processor's name, including one that the user named, or None if kernels are compiled for
    just this machine.
    """
    if "NUMBA_CPU_NAME" in environment or "NUMBA_CPU_FEATURES" in environment:
        return environment.get("NUMBA_CPU_NAME")
    try:
        cpuinfo = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace")
    except OSError:
        return None
    name = common_processor(platform.machine(), cpuinfo)
    # numba has no public sign of having read its processor; it makes this when it does
    if name is None or "_toplevel_target_context" in vars(cpu_target):
        return None
    config: Any = numba.config
    config.CPU_NAME, config.CPU_FEATURES = name, ""
    return name


def _flags(cpuinfo: str) -> frozenset[str]:
    """Features that every processor of the machine has."""
    lines = [line for line in cpuinfo.splitlines() if line.startswith("flags")]
    each = [frozenset(line.partition(":")[2].split()) for line in lines]
    return frozenset.intersection(*each) if each else frozenset()
