"""Long work at a terminal: a line with its stage and time, and Ctrl-C that ends it at once.

Compiled kernels see no Python signal before they return, which takes seconds on a large picture.
During pure computing Ctrl-C is left to the operating system: nothing is open that could be left
half written.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

PATIENCE_S: Final = 1.0
"""Shorter work says nothing."""
EVERY_S: Final = 0.5
CLEAR_LINE: Final = "\r\x1b[2K"


def is_live() -> bool:
    """True if a line on stderr can be renewed."""
    return sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") != "dumb"


@contextmanager
def long_work(first: str) -> Iterator[Callable[[str], None]]:
    """Do long work, ``first`` to begin with; call the yielded function with each later stage."""
    stage = [first]

    def begin(name: str) -> None:
        stage[0] = name

    with _ended_by_ctrl_c(), _told(lambda: stage[0]):
        yield begin


@contextmanager
def _ended_by_ctrl_c() -> Iterator[None]:
    in_main = threading.current_thread() is threading.main_thread()
    if not in_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield  # another handler, or ignored as under nohup
        return
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@contextmanager
def _told(stage: Callable[[], str]) -> Iterator[None]:
    if not is_live():
        yield
        return
    began_s, over = time.monotonic(), threading.Event()

    def tell() -> None:
        if over.wait(PATIENCE_S):
            return
        while True:
            passed_s = time.monotonic() - began_s
            sys.stderr.write(f"{CLEAR_LINE}{stage()} ... {passed_s:.0f} s")
            sys.stderr.flush()
            if over.wait(EVERY_S):
                break
        sys.stderr.write(CLEAR_LINE)
        sys.stderr.flush()

    teller = threading.Thread(target=tell, name="progress", daemon=True)
    teller.start()
    try:
        yield
    finally:
        over.set()
        teller.join()
