"""A V4L2 camera whose reader was frozen: what fills the buffers is of before."""

from __future__ import annotations

import errno
import os
from ctypes import c_int32
from dataclasses import dataclass, field
from typing import cast

import numpy as np
import pytest

from vision.camera.v4l2 import structs
from vision.camera.v4l2.device import DeviceCamera
from vision.camera.v4l2.node import Node
from vision.camera.v4l2.stream import BUFFERS, Agreed, Stream

SIZE = (4, 2)
PICTURE_S = 1.0 / 30.0


@dataclass
class Driver:
    """Fills queued buffers with the number of the picture, and waits while it has none."""

    fd: int
    now_s: float = 1000.0
    stamps_off_s: float = 0.0
    """Its clock, less ours."""
    path: str = "/dev/null"
    _queued: list[int] = field(default_factory=list)
    _filled: list[tuple[int, float]] = field(default_factory=list)

    def ask(self, request: int, about: structs.Buffer | c_int32) -> object:
        if request == structs.QUERYBUF:
            about.length = 4096
            about.m.offset = 4096 * about.index
        elif request == structs.QBUF:
            self._queued.append(about.index)
        elif request == structs.DQBUF:
            if not self._filled:
                raise OSError(errno.EAGAIN, "nothing is filled")
            about.index, stamp_s = self._filled.pop(0)
            about.bytesused, about.length = SIZE[0] * SIZE[1], 4096
            about.timestamp.tv_sec = int(stamp_s)
            about.timestamp.tv_usec = int(stamp_s % 1.0 * 1e6)
        return about

    def passes(self, seconds: float) -> None:
        for _ in range(round(seconds / PICTURE_S)):
            self.now_s += PICTURE_S
            if self._queued:
                index, taken_s = self._queued.pop(0), self.now_s - self.stamps_off_s
                number = round((self.now_s - 1000.0) / PICTURE_S) % 256
                os.pwrite(self.fd, bytes([number] * 8), 4096 * index)
                self._filled.append((index, taken_s))


@pytest.fixture
def driver() -> Driver:
    fd = os.memfd_create("buffers")
    os.truncate(fd, 4096 * BUFFERS)
    return Driver(fd)


def camera_on(driver: Driver) -> DeviceCamera:
    camera = DeviceCamera("/dev/null", lambda: driver.now_s, 30.0, SIZE)
    stream = Stream(cast("Node", driver), lambda: driver.now_s)
    stream.start()
    camera._node = cast("Node", driver)
    camera._stream, camera.mode = stream, Agreed("GREY", SIZE, SIZE[0], 30.0)
    return camera


@pytest.mark.parametrize("stamps_off_s", [0.0, 500.0], ids=["our clock", "another clock"])
@pytest.mark.parametrize("frozen_s", [0.05, 0.4, 1.0, 30.0])
def test_no_picture_is_dated_later_than_it_was_taken(
    driver: Driver, frozen_s: float, stamps_off_s: float
) -> None:
    driver.stamps_off_s = stamps_off_s
    camera = camera_on(driver)
    driver.passes(0.05)
    assert camera.read(0.0) is not None
    driver.passes(frozen_s)
    frames = [camera.read(0.0)]
    for _ in range(3):
        driver.passes(0.034)
        frames.append(camera.read(0.0))
    assert any(frame is not None for frame in frames)
    for frame in frames:
        if frame is not None:
            taken_s = driver.now_s - PICTURE_S * (
                (round((driver.now_s - 1000.0) / PICTURE_S) - int(np.mean(frame.image))) % 256
            )
            assert frame.captured_s == pytest.approx(taken_s, abs=0.15)
