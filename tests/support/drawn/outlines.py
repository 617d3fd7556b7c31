"""Outlines that are still to be filled, for the tests of single kernels."""

from __future__ import annotations

import numpy as np

from vision.outline.fitting_kernels import share_out
from vision.outline.fitting_memory import make_memory
from vision.outline.outline_types import Outline, Scratch


def blank_outline(edges: int) -> Outline:
    """An outline of so many edges, none of them a fillet."""
    return Outline(
        np.empty(edges, np.int64),
        np.empty(edges, np.bool_),
        np.zeros(edges, np.bool_),
        np.empty((edges, 5)),
        np.empty((edges, 2)),
        np.empty((edges, 2), np.int64),
        np.empty((edges, 2), np.bool_),
        np.empty(edges, np.int64),
    )


def scratch_for(points: int) -> Scratch:
    """Scratch space for a border of this number of points."""
    scratch: Scratch = getattr(share_out, "py_func", share_out)(make_memory(points + 1)).scratch
    return scratch
