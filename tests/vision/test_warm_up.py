"""What unusual light asks for is compiled before a run begins."""

from __future__ import annotations

import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

COUNT = """
import sys
from vision.binarise import binarise_kernels as b, smoothing_kernels as c
from vision.binarise.regions import edge_evidence_kernels as s
from vision.binarise.binarise import warm_up
warm_up(sys.argv[1])
kernels = (b.sampled_histogram, b.noise_sigma, b.split_histogram, b.steepest_level,
           b.flat_histogram, c.smoothed_histogram, c.mark_below_but_dots, c.mark_dots,
           c.dots_left_out, s.steps_across_level, s.typical_step, s.support_by_level,
           s.steps_of_regions, s.steps_off_level)
print([k.py_func.__name__ for k in kernels if not k.signatures])
"""
TWICE = """
import sys
import numpy as np
from vision.binarise.binarise import binarise, warm_up
warm_up(sys.argv[1])
for kind in (np.uint8, np.uint16):
    picture = np.full((96, 128, 3), 200, kind)
    picture[20:60, 20:50] = 40
    for each in (picture, picture[8:-8, 8:-8], picture[:, :, 0]):
        binarise(each, polarity=sys.argv[1])
twice = []
for name, module in sys.modules.items():
    if name.startswith("vision.binarise.") and name.endswith("_kernels"):
        for kernel in vars(module).values():
            signatures = getattr(kernel, "signatures", ())
            whatever = [str(one).replace("True, aligned", "False, aligned") for one in signatures]
            if len(set(whatever)) < len(whatever):
                twice.append(kernel.py_func.__name__)
print(twice)
"""


@pytest.mark.parametrize("polarity", ["dark", "light"])
def test_every_kernel_of_binarisation_is_there_after_the_warm_up(polarity: str) -> None:
    assert said(polarity)[0] == "[]"


@pytest.mark.parametrize("polarity", ["dark", "light"])
def test_no_kernel_is_compiled_once_more_for_a_picture_that_may_be_changed(polarity: str) -> None:
    assert said(polarity)[1] == "[]"


@cache
def said(polarity: str) -> list[str]:
    """The lines of both programs, one after the other in one process."""
    done = subprocess.run(
        [sys.executable, "-c", COUNT + TWICE, polarity],
        capture_output=True, text=True, check=True, timeout=300, cwd=Path(__file__).parents[2],
    )  # fmt: skip
    return done.stdout.splitlines()
