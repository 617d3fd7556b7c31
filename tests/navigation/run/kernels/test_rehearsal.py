"""What wheels compile ahead is found by running it: the rehearsal itself has to go through."""

import subprocess
import sys
from pathlib import Path

import pytest

RUN = """
import navigation.run.kernels.rehearsal as rehearsal
rehearsal.see_an_arena = rehearsal.compile_planner = lambda: None  # the warm-up has its own tests
rehearsal.{part}()
"""


@pytest.mark.parametrize("part", ["rehearse_eye", "rehearse_planner"])
def test_the_rehearsal_goes_through(part: str) -> None:
    told = subprocess.run(
        [sys.executable, "-c", RUN.format(part=part)],
        cwd=Path(__file__).parents[4],
        capture_output=True,
        text=True,
        timeout=280,
    )
    assert told.returncode == 0, told.stderr
