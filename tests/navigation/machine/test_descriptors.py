"""Descriptors: the limit is what `select` takes, and spare ones let one more thing open."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from navigation.machine.descriptors import (
    WANTED,
    SpareDescriptors,
    descriptor_limit,
    set_descriptor_limit,
)

ROOT = Path(__file__).parents[3]


@pytest.fixture
def limits() -> Iterator[tuple[int, int]]:
    """This process's limits, which are put back."""
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    yield before
    resource.setrlimit(resource.RLIMIT_NOFILE, before)


def test_the_soft_limit_is_what_select_can_take(limits: tuple[int, int]) -> None:
    _soft, hard = limits
    resource.setrlimit(resource.RLIMIT_NOFILE, (256, hard))
    assert set_descriptor_limit(512) == descriptor_limit() == 512
    assert set_descriptor_limit(300) == descriptor_limit() == 300
    assert resource.getrlimit(resource.RLIMIT_NOFILE)[1] == hard


ABOVE_THE_HARD_LIMIT = """
import resource
from navigation.machine.descriptors import set_descriptor_limit
resource.setrlimit(resource.RLIMIT_NOFILE, (128, 200))
print(set_descriptor_limit())
"""


def test_the_hard_limit_is_the_most() -> None:
    told = subprocess.run(
        [sys.executable, "-c", ABOVE_THE_HARD_LIMIT],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert told.stdout == "200\n"
    assert WANTED <= 1024, "select takes no more"


def take_all() -> list[int]:
    """Open one after another until none is left."""
    taken = []
    try:
        while True:
            taken.append(os.open(os.devnull, os.O_RDONLY))
    except OSError:
        return taken


def test_a_spare_one_lets_one_more_open_where_none_is_left(limits: tuple[int, int]) -> None:
    spare = SpareDescriptors(2)
    used = len(os.listdir("/proc/self/fd"))
    resource.setrlimit(resource.RLIMIT_NOFILE, (used + 32, limits[1]))
    taken = take_all()
    for _ in range(2):
        assert spare.release()
        taken.append(os.open(os.devnull, os.O_RDONLY))
    assert not spare.release()
    spare.refill()
    assert not spare.release(), "there was none to hold back"
    for one in taken:
        os.close(one)
    spare.refill()
    assert spare.release()
    spare.close()
