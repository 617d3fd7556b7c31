"""The pose that a robot in another process tells the simulated camera."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from navigation.simulator.shared_pose import PoseFileError, SharedPose


def test_what_one_end_writes_the_other_reads(tmp_path: Path) -> None:
    writer = SharedPose(tmp_path / "new" / "pose", write=True)
    reader = SharedPose(tmp_path / "new" / "pose", write=False)
    with pytest.raises(PoseFileError, match="nobody has written a pose into it"):
        reader.read()
    writer.write(1.25, -0.5, 3.0)
    assert reader.read() == (1.25, -0.5, 3.0)


def test_a_reader_outlives_the_writer_and_goes_on_with_the_next(tmp_path: Path) -> None:
    first = SharedPose(tmp_path / "pose", write=True)
    first.write(1.0, 2.0, 3.0)
    reader = SharedPose(tmp_path / "pose", write=False)
    first.close()
    second = SharedPose(tmp_path / "pose", write=True)
    assert reader.read() == (1.0, 2.0, 3.0)
    second.write(4.0, 5.0, 0.5)
    assert reader.read() == (4.0, 5.0, 0.5)


def test_a_missing_file_is_said_with_what_helps(tmp_path: Path) -> None:
    with pytest.raises(PoseFileError, match=r"pose file .*: .*does `clearway robot` run\?"):
        SharedPose(tmp_path / "none", write=False)


def test_a_reader_never_sees_half_of_a_pose(tmp_path: Path) -> None:
    writer = SharedPose(tmp_path / "pose", write=True)
    reader = SharedPose(tmp_path / "pose", write=False)
    writer.write(0.0, 0.0, 0.0)
    over = threading.Event()

    def write() -> None:
        number = 0.0
        while not over.is_set():
            number += 1.0
            writer.write(number, number, number)

    thread = threading.Thread(target=write)
    thread.start()
    try:
        for _ in range(5000):
            assert len(set(reader.read())) == 1
    finally:
        over.set()
        thread.join()
