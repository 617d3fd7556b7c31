"""Helper processes that end with this one, whatever ends it.

A child that only obeys an order to end would outlive a killed parent. So it watches its parent
itself.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import wait
from multiprocessing.context import SpawnContext, SpawnProcess

FRESH: SpawnContext = multiprocessing.get_context("spawn")
"""Maker of fresh processes: a fork would copy OpenCV's and the kernels' threads in mid-work."""
ORPHANED = 1
"""Exit code of a child whose parent has ended."""


def start_child(work: Callable[..., None], *arguments: object) -> SpawnProcess:
    """Run ``work``, a function of a module, in a process that ends with this one."""
    child = FRESH.Process(target=_work, args=(work, arguments), daemon=True)
    child.start()
    return child


@contextmanager
def interrupts_wait() -> Iterator[None]:
    """Hold SIGINT and SIGTERM back: a child whose start is cut short prints a traceback."""
    came: list[int] = []
    before = {}
    if threading.current_thread() is threading.main_thread():  # no other one is interrupted
        for number in (signal.SIGINT, signal.SIGTERM):
            before[number] = signal.signal(number, lambda number, _: came.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for late in came:
            signal.raise_signal(late)


def end_with_parent() -> None:
    """End at once when the parent has ended; for a process made by `multiprocessing`."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    sentinel = parent.sentinel

    def watch() -> None:
        wait([sentinel])
        os._exit(ORPHANED)

    threading.Thread(target=watch, name="parent", daemon=True).start()


def _work(work: Callable[..., None], arguments: tuple[object, ...]) -> None:
    end_with_parent()
    # Ctrl-C in a terminal reaches parent and child alike; the parent must end the child
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    work(*arguments)
