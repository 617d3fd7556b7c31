"""A robot under the real MicroPython, in a process of its own."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.support.robots.micropython_interpreter import interpreter
from tests.support.robots.micropython_robot import Process


@pytest.fixture(scope="module")
def process() -> Iterator[Process]:
    found = interpreter()
    assert found is not None
    process = Process([found])
    yield process
    process.close()
