"""What unusual light asks for is compiled before a run begins."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

COUNT = """
import sys
from vision.binarise import binarise_kernels as b, dot_kernels as d, smoothing_kernels as c
from vision.binarise.regions import edge_evidence_kernels as s
from vision.binarise.binarise import warm_up
warm_up(sys.argv[1])
kernels = (b.sampled_histogram, b.noise_sigma, b.split_histogram, b.steepest_level,
           b.flat_histogram, c.calmed_histogram, d.mark_below_but_dots, d.mark_dots,
           d.dots_left_out, s.steps_across_level, s.typical_step, s.support_by_level,
           s.steps_of_regions, s.steps_off_level)
print([k.py_func.__name__ for k in kernels if not k.signatures])
"""


@pytest.mark.parametrize("polarity", ["dark", "light"])
def test_every_kernel_of_binarisation_is_there_after_the_warm_up(polarity: str) -> None:
    root = Path(__file__).parents[2]
    done = subprocess.run(
        [sys.executable, "-c", COUNT, polarity],
        capture_output=True, text=True, check=True, timeout=300, cwd=root,
    )  # fmt: skip
    assert done.stdout.strip() == "[]"
