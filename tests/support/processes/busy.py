"""Processes that want the processor all the time: a computer under load."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Final

PROGRAM: Final = """
import os
parent = os.getppid()
while os.getppid() == parent:
    sum(range(100_000))
"""
"""They end with whoever started them, however that ends."""


@contextmanager
def busy(count: int) -> Iterator[None]:
    """So many of them, of the same priority as everything else."""
    with ExitStack() as until:
        for _ in range(count):
            process = subprocess.Popen([sys.executable, "-S", "-c", PROGRAM])
            until.callback(process.wait)
            until.callback(process.kill)
        yield
