"""The pose that a robot in another process tells the simulated camera."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from navigation.simulator.shared_pose import PoseFileError, PoseReader, PoseWriter

POSE = (1.25, -0.5, 3.0)


def test_what_one_end_writes_the_other_reads(tmp_path: Path) -> None:
    writer = PoseWriter(tmp_path / "new" / "pose")
    reader = PoseReader(tmp_path / "new" / "pose")
    with pytest.raises(PoseFileError, match="no pose has been written into it"):
        reader.read()
    writer.write(*POSE)
    assert reader.read() == POSE


def test_a_reader_outlives_the_writer_and_goes_on_with_the_next(tmp_path: Path) -> None:
    first = PoseWriter(tmp_path / "pose")
    first.write(1.0, 2.0, 3.0)
    reader = PoseReader(tmp_path / "pose")
    first.close()
    second = PoseWriter(tmp_path / "pose")
    assert reader.read() == (1.0, 2.0, 3.0)
    second.write(4.0, 5.0, 0.5)
    assert reader.read() == (4.0, 5.0, 0.5)


def test_a_missing_file_is_said_with_what_helps(tmp_path: Path) -> None:
    with pytest.raises(PoseFileError, match=r"pose file .*: .*does `clearway robot` run\?"):
        PoseReader(tmp_path / "none")


def cut(path: Path) -> None:
    os.truncate(path, 7)


def empty(path: Path) -> None:
    os.truncate(path, 0)


def fill_with_zeros(path: Path) -> None:
    path.write_bytes(bytes(path.stat().st_size))


def fill_with_text(path: Path) -> None:
    path.write_text("no pose at all, but as long as one, or longer\n" * 3)


def make_a_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def make_a_fifo(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


@pytest.mark.parametrize(
    "spoil",
    [cut, empty, fill_with_zeros, fill_with_text, Path.unlink, make_a_folder, make_a_fifo],
)
def test_whatever_becomes_of_the_file_is_no_pose_and_the_reader_follows_the_next(
    spoil: Callable[[Path], None], tmp_path: Path
) -> None:
    """The file was mapped once: cutting it short killed its reader with SIGBUS."""
    path = tmp_path / "pose"
    writer, reader = PoseWriter(path), PoseReader(path)
    writer.write(*POSE)
    assert reader.read() == POSE
    spoil(path)
    with pytest.raises(PoseFileError, match="pose file"):
        reader.read()
    if path.is_dir():
        path.rmdir()
    elif path.is_fifo():
        path.unlink()
    PoseWriter(path).write(4.0, 5.0, 0.5)
    assert reader.read() == (4.0, 5.0, 0.5)


@pytest.mark.parametrize("spoil", [cut, empty, fill_with_zeros, fill_with_text, Path.unlink])
def test_a_writer_mends_its_file(spoil: Callable[[Path], None], tmp_path: Path) -> None:
    path = tmp_path / "pose"
    writer, reader = PoseWriter(path), PoseReader(path)
    writer.write(0.0, 0.0, 0.0)
    spoil(path)
    writer.write(*POSE)
    assert reader.read() == POSE


def test_a_file_that_is_replaced_under_both_is_followed_by_both(tmp_path: Path) -> None:
    path = tmp_path / "pose"
    writer, reader = PoseWriter(path), PoseReader(path)
    PoseWriter(tmp_path / "other").write(4.0, 5.0, 0.5)
    (tmp_path / "other").replace(path)
    assert reader.read() == (4.0, 5.0, 0.5)
    writer.write(*POSE)
    assert reader.read() == POSE


def test_a_path_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(PoseFileError, match=r"pose file .*folder: Is a directory"):
        PoseWriter(tmp_path / "folder")
    (tmp_path / "file").touch()
    with pytest.raises(PoseFileError, match="pose file"):
        PoseWriter(tmp_path / "file" / "pose")


def test_a_reader_never_sees_half_of_a_pose(tmp_path: Path) -> None:
    writer = PoseWriter(tmp_path / "pose")
    reader = PoseReader(tmp_path / "pose")
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
