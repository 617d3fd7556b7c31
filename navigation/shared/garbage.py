"""Python's garbage collector, kept away from what a program imports.

A command makes some 200 000 objects before it computes: modules, classes, numba's registries. Most
of them stay, but the collector searched them for cycles again and again, which took a seventh of
``clearway plan``. Now the first search comes later, and what it leaves is never searched again.
"""

from __future__ import annotations

import gc

IMPORTED = 500_000
"""Objects before the first search. By ``gc.get_count()``, without the collector, a plan makes
200 000 to its end, and a run 350 000 until its kernels are loaded."""
USUAL = gc.get_threshold()


def postpone_collection() -> None:
    """Search for garbage after ``IMPORTED`` objects, or as soon as `resume_collection` is called.

    A ``gc.collect()`` resumes it, too.
    """
    gc.callbacks.append(_settle)
    gc.set_threshold(IMPORTED, *USUAL[1:])


def resume_collection() -> None:
    """Search as usual, but only objects made from now on; do nothing if it was not postponed."""
    if _settle in gc.callbacks:
        gc.callbacks.remove(_settle)
        gc.freeze()
        gc.set_threshold(*USUAL)


def _settle(phase: str, _info: dict[str, int]) -> None:
    if phase == "stop":
        resume_collection()
