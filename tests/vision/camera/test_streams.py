"""A network camera served by the test itself: its frames, and each way in which it can fail."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
import pytest

from tests.support.processes.mjpeg_server import RATE_HZ, MjpegServer, mjpeg_server
from vision.camera.arrival_clock import ArrivalClock
from vision.camera.camera import Image
from vision.camera.capture import StreamCamera
from vision.camera.latest_frame import CameraStatus, LatestFrame, WatchLimits
from vision.camera.sources import camera_for

QUICK = WatchLimits(stalled_s=0.4, frozen_s=0.4, hung_s=2.0, first_pause_s=0.1, longest_pause_s=0.4)


@pytest.fixture
def server() -> Iterator[MjpegServer]:
    with mjpeg_server() as running:
        yield running


def reader_of(server: MjpegServer) -> LatestFrame:
    return LatestFrame(lambda: camera_for(server.url, clock=time.monotonic), time.monotonic, QUICK)


def wait_for(
    reader: LatestFrame, wanted: Callable[[CameraStatus], bool], timeout_s: float = 20.0
) -> CameraStatus:
    """The status as soon as it is what was wanted; frames are taken meanwhile."""
    end_s = time.monotonic() + timeout_s
    while time.monotonic() < end_s:
        reader.take(0.02)
        status = reader.status()
        if wanted(status):
            return status
    pytest.fail(f"still {reader.status()}")


def test_frames_come_in_order_at_the_rate_served(server: MjpegServer) -> None:
    camera = camera_for(server.url, clock=time.monotonic)
    camera.open()
    frames = [camera.read(1.0) for _ in range(30)]
    end_s = time.monotonic() + 30.0
    while camera.rate_hz == 0.0 and time.monotonic() < end_s:
        camera.read(1.0)
    for _ in range(10):
        camera.read(1.0)
    camera.close()
    greys = [int(f.image[40, 50].mean()) for f in frames if f is not None]
    assert len(greys) == 30
    steps = [(b - a) % 200 for a, b in pairwise(greys)]
    assert all(3 <= step <= 7 for step in steps), greys
    assert [f.sequence for f in frames if f is not None] == list(range(30))
    # The first frames come in a burst that does not count; a busy machine is late.
    assert 0.1 * RATE_HZ < camera.rate_hz < 2.0 * RATE_HZ


def test_the_burst_that_a_stream_begins_with_is_not_its_rate(server: MjpegServer) -> None:
    now_s = [100.0]
    camera = camera_for(server.url, clock=lambda: now_s[0])
    camera.open()
    for _ in range(20):
        assert camera.read(1.0) is not None
        now_s[0] += 0.001
    assert camera.rate_hz == 0.0
    now_s[0] += 1.0
    for _ in range(5):
        assert camera.read(1.0) is not None
        now_s[0] += 0.04
    camera.close()
    assert abs(camera.rate_hz - 25.0) < 0.01


def test_a_stream_that_falls_silent_is_noticed_and_taken_up_again(server: MjpegServer) -> None:
    with reader_of(server) as reader:
        wait_for(reader, lambda s: s.state == "running" and s.captured > 3)
        server.mode = "stalled"
        status = wait_for(reader, lambda s: s.state == "stalled")
        assert "no picture for" in status.reason
        server.mode = "live"
        wait_for(reader, lambda s: s.state == "running" and s.age_s is not None and s.age_s < 0.3)


def test_a_frozen_stream_is_noticed_and_opened_again(server: MjpegServer) -> None:
    with reader_of(server) as reader:
        wait_for(reader, lambda s: s.state == "running" and s.captured > 3)
        server.mode = "frozen"
        status = wait_for(reader, lambda s: s.state == "frozen")
        assert "the camera is frozen; trying again in" in status.reason
        server.mode = "live"
        status = wait_for(reader, lambda s: s.state == "running")
        assert status.reopened >= 1


def test_a_lost_stream_is_tried_again_with_growing_pauses_until_it_is_back(
    server: MjpegServer,
) -> None:
    with reader_of(server) as reader:
        wait_for(reader, lambda s: s.state == "running" and s.captured > 3)
        server.mode = "lost"
        wait_for(reader, lambda s: s.state == "lost" and s.reopened >= 3)
        assert "trying again in 0.4 s" in wait_for(reader, lambda s: "0.4" in s.reason).reason
        before = server.connections
        server.mode = "live"
        wait_for(reader, lambda s: s.state == "running")
        assert server.connections > before


@pytest.mark.parametrize("kind", ["http", "rtsp"])
def test_a_server_that_never_answers_is_told_and_not_taken_for_a_hung_driver(kind: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        url = f"{kind}://127.0.0.1:{silent.getsockname()[1]}/live"
        clock = time.monotonic
        with LatestFrame(lambda: camera_for(url, clock=clock), clock) as reader:
            status = wait_for(reader, lambda s: s.state == "lost", 60.0)
    assert "no answer within 5 s; trying again in 0.25 s" in status.reason
    assert status.reopened == 1


class _Held:
    """A capture of an RTSP stream whose pictures, 40 ms apart, are held up now and then."""

    def __init__(self, held_s: Callable[[int], float], restart_at: int = -1) -> None:
        self.number = -1
        self.now_s = 100.0
        self._held_s, self._restart_at = held_s, restart_at

    def grab(self) -> bool:
        self.number += 1
        self.now_s = max(self.now_s, self.sent_s + self._held_s(self.number))
        return True

    @property
    def sent_s(self) -> float:
        return 100.0 + 0.04 * self.number

    def retrieve(self) -> tuple[bool, Image]:
        return True, np.zeros((4, 4, 3), np.uint8)

    def get(self, _property: int) -> float:
        restarted = 0 <= self._restart_at <= self.number
        return 40.0 * (self.number - self._restart_at if restarted else self.number)


def test_pictures_of_an_rtsp_stream_that_are_held_up_are_dated_by_their_stamps() -> None:
    held = _Held(lambda n: 0.3 if n % 20 == 5 else 0.01)
    camera = StreamCamera("rtsp://127.0.0.1/none", lambda: held.now_s)
    camera._capture, camera._sender = held, ArrivalClock()  # type: ignore[assignment]
    for n in range(200):
        frame = camera.read(0.1)
        assert frame is not None
        assert frame.captured_s <= held.now_s
        assert frame.captured_s == pytest.approx(held.sent_s + 0.01, abs=0.002), n


def test_a_stream_whose_stamps_begin_again_or_lie_is_dated_by_its_arrival() -> None:
    held = _Held(lambda _n: 0.0, restart_at=50)
    camera = StreamCamera("rtsp://127.0.0.1/none", lambda: held.now_s)
    camera._capture, camera._sender = held, ArrivalClock()  # type: ignore[assignment]
    for _ in range(120):
        frame = camera.read(0.1)
        assert frame is not None
        assert abs(frame.captured_s - held.now_s) < 0.002


def test_an_http_streams_made_up_times_are_not_believed() -> None:
    held = _Held(lambda n: 0.04 * n)
    camera = StreamCamera("http://127.0.0.1/none", lambda: held.now_s)
    camera._capture = held  # type: ignore[assignment]
    for _ in range(50):
        frame = camera.read(0.1)
        assert frame is not None
        assert frame.captured_s == held.now_s
