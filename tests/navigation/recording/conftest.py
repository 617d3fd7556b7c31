"""Recordings that several tests read."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.runs.recordings import EVERY, RecordedBench, make_recording


def see_and_plan(bench: RecordedBench) -> None:
    bench.frames(8)
    bench.plan()
    bench.frames(4)


@pytest.fixture(scope="module")
def lossless(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Twelve frames without loss, a scene and a plan."""
    (file,) = make_recording(tmp_path_factory.mktemp("lossless"), see_and_plan, **EVERY)
    return file


@pytest.fixture(scope="module")
def jpeg(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same as a run records it unless it is told otherwise."""
    (file,) = make_recording(tmp_path_factory.mktemp("jpeg"), see_and_plan)
    return file
