"""Compile the kernels in processes of their own, and report progress.

Each process runs one part of the program on a small example. This one only waits, so it can be
ended at once.
"""

from __future__ import annotations

import gc
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any

from numba.core import event  # documented: numba's manual for developers, "Event API"
from numba.extending import is_jitted

from navigation.machine.child import FRESH, interrupts_wait, start_child

REPORT_EVERY_S = 0.5
RARELY = (50_000, 20, 100)
"""Thresholds of the garbage collector: the default ones cost a tenth of the compiling time and free
next to nothing."""
EARLY = 0.05
"""Share of kernels that must be done before the remaining time can be estimated."""


@dataclass(frozen=True)
class CompileProgress:
    """Kernels done and known so far, and parts that ended."""

    done: int
    known: int
    passed_s: float
    ended: tuple[str, ...] = ()
    failed: tuple[str, ...] = ()

    @property
    def left_s(self) -> float | None:
        """Estimate of the remaining seconds; None without a basis for one."""
        if self.done < EARLY * self.known or self.done == 0:
            return None
        return self.passed_s * (self.known - self.done) / self.done

    def __str__(self) -> str:
        left = "" if self.left_s is None else f", about {self.left_s:.0f} s left"
        return f"{self.done} of {self.known} kernels{left}"


def compile_parts(
    parts: Mapping[str, tuple[Callable[..., None], tuple[object, ...]]],
) -> Iterator[CompileProgress]:
    """Run each part, a module's function and its arguments, in a process; yield the progress.

    The processes end with the iterator.
    """
    children: dict[str, SpawnProcess] = {}
    pipes: dict[Connection, str] = {}
    begin_s = time.monotonic()
    done: set[str] = set()
    known = 0
    ended: list[str] = []
    try:
        with interrupts_wait():
            for name, (work, arguments) in parts.items():
                ours, theirs = FRESH.Pipe(duplex=False)
                children[name] = start_child(_compile_and_count, theirs, work, arguments)
                theirs.close()
                pipes[ours] = name
        while pipes:
            for pipe in wait(list(pipes)):
                assert isinstance(pipe, Connection)
                name = pipes[pipe]
                try:
                    compiled, known_there = pipe.recv()
                    done.update(compiled)
                    known = max(known, known_there, len(done))
                except EOFError:
                    children[name].join()
                    ended.append(name)
                    del pipes[pipe]
                failed = tuple(one for one in ended if children[one].exitcode != 0)
                passed_s = time.monotonic() - begin_s
                yield CompileProgress(len(done), known, passed_s, tuple(ended), failed)
    finally:
        for child in children.values():
            child.kill()
            child.join()


def _compile_and_count(
    pipe: Connection, work: Callable[..., None], arguments: tuple[object, ...]
) -> None:
    gc.set_threshold(*RARELY)
    counter = _Counter(pipe)
    with event.install_listener("numba:compile", counter):
        work(*arguments)
    counter.finish()


class _Counter(event.Listener):
    """Counts each of our kernels once for all its types."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self._news: list[str] = []
        self._reported_s = 0.0

    def on_start(self, happened: Any) -> None:
        """Called by numba before each compilation."""

    def on_end(self, happened: Any) -> None:
        """Called by numba after each compilation."""
        kernel = happened.data["dispatcher"].py_func
        if kernel.__module__.partition(".")[0] in ("planner", "vision"):
            self._news.append(f"{kernel.__module__}.{kernel.__qualname__}")
        if time.monotonic() - self._reported_s >= REPORT_EVERY_S:
            self._reported_s = time.monotonic()
            self._report()

    def finish(self) -> None:
        self._report()
        self._pipe.close()

    def _report(self) -> None:
        self._pipe.send((self._news, _kernels_known()))
        self._news = []


def _kernels_known() -> int:
    modules = [
        module
        for name, module in list(sys.modules.items())
        if name.startswith(("planner.", "vision.")) and name.endswith("_kernels")
    ]
    return sum(
        is_jitted(kernel) and kernel.py_func.__module__ == module.__name__
        for module in modules
        for kernel in vars(module).values()
    )
