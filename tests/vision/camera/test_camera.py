"""Frames, and the newest of a source that stalls, freezes, hangs and comes back."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import numpy as np
import pytest

from tests.support.waiting import wait_until
from tests.vision.camera.scripted import Clock, Event, ScriptedCamera, picture, reader_of
from vision.camera.camera import Camera, CameraError, CameraHeldError, Frame, RateMeter
from vision.camera.latest_frame import MOST_LEFT_BEHIND, LatestFrame, WatchLimits


def test_a_frame_cannot_be_written_and_leaves_its_array_alone() -> None:
    image = picture(3)
    frame = Frame(image, 1.0, 0, "x")
    assert not frame.image.flags.writeable
    assert image.flags.writeable
    assert frame.size == (8, 8)


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((0, 5), np.uint8),
        np.zeros((5, 5), np.uint16),
        np.zeros((5, 5, 4), np.uint8),
        np.zeros(5, np.uint8),
    ],
)
def test_what_is_no_picture_is_no_frame(image: np.ndarray) -> None:
    with pytest.raises(CameraError, match="picture"):
        Frame(image, 0.0, 0, "x")


def test_the_rate_is_the_one_really_got() -> None:
    meter = RateMeter()
    assert meter.rate_hz == 0.0
    for i in range(10):
        meter.add(i / 25.0)
    assert meter.rate_hz == pytest.approx(25.0)
    meter.add(0.0)  # the clock's origin is another one: count afresh
    assert meter.rate_hz == 0.0


def test_the_latest_frame_wins_and_drops_are_counted() -> None:
    clock = Clock()
    reader, _ = reader_of(clock, [picture(i) for i in range(5)])
    for _ in range(6):
        reader.step()
    frame = reader.take()
    assert frame is not None
    assert frame.image[0, 0] == 4
    assert frame.sequence == 4
    assert reader.take() is None
    status = reader.status()
    assert (status.captured, status.dropped, status.state) == (5, 4, "running")


def test_a_wait_for_a_frame_ends_at_once_when_it_is_woken() -> None:
    """With an hour's patience: only the wake-up can end the wait."""
    reader, _ = reader_of(Clock(), [picture(1)])
    found: list[Frame | None] = []
    waiter = threading.Thread(target=lambda: found.append(reader.take(3600.0)), daemon=True)
    waiter.start()
    reader.wake()
    waiter.join(60.0)
    assert found == [None]


def test_a_wake_up_before_the_wait_is_not_lost_and_hides_no_frame() -> None:
    reader, _ = reader_of(Clock(), [picture(1)])
    reader.wake()
    assert reader.take(3600.0) is None
    for _ in range(2):
        reader.step()
    reader.wake()
    assert reader.take(3600.0) is not None


def test_a_lost_source_is_opened_again_with_growing_pauses() -> None:
    clock = Clock()
    lost: list[Event] = [CameraError("camera T: unplugged")]
    reader, cameras = reader_of(clock, lost, lost, lost, [picture(1), picture(2)])
    pauses = []
    for _ in range(3):
        reader.step()
        pauses.append(reader.step())
        assert reader.status().state == "lost"
        assert "unplugged" in reader.status().reason
        assert "trying again in" in reader.status().reason
        assert reader.step() > 0.0, "opened again before the pause was over"
        clock.wait(pauses[-1])
    assert pauses == [0.25, 0.5, 1.0]
    for _ in range(3):
        reader.step()
    assert reader.status().state == "running"
    assert reader.status().reopened == 3
    assert [c.closed for c in cameras[:3]] == [1, 1, 1]


def test_the_pauses_are_bounded_for_ever() -> None:
    clock = Clock()

    def refuse() -> Camera:
        raise CameraError("camera T: busy")

    reader = LatestFrame(refuse, clock)
    for _ in range(2000):
        pause_s = reader.step()
        assert 0.0 < pause_s <= WatchLimits().longest_pause_s
        clock.wait(pause_s)
    assert "busy" in reader.status().reason


def test_a_source_that_gives_nothing_is_stalled() -> None:
    clock = Clock()
    reader, _ = reader_of(clock, [picture(1), picture(2), *[None] * 50], [picture(3)])
    for _ in range(4):
        reader.step()
    states = set()
    for _ in range(12):
        reader.step()
        states.add(reader.status().state)
    assert "stalled" in states
    assert "no picture for" in reader.status().reason


def test_a_frozen_picture_is_no_news_and_is_noticed() -> None:
    clock = Clock()
    same = picture(7)
    reader, _ = reader_of(clock, [picture(1), same, *[same] * 30], [same] * 30, [picture(9)] * 3)
    for _ in range(3):
        reader.step()
    assert reader.take() is not None
    for _ in range(14):
        reader.step()
        assert reader.take() is None, "a repeated picture was passed on as new"
    assert reader.status().state == "frozen"
    clock.wait(1.0)
    for _ in range(15):
        reader.step()
    assert reader.take() is None, "still the same frozen picture after opening again"
    assert reader.status().state == "frozen"
    clock.wait(2.0)
    reader.step()
    reader.step()
    assert reader.status().state == "running"


def test_a_still_arena_over_a_thin_stream_is_not_frozen() -> None:
    """At 5 frames a second, nine equal ones take 1.8 s: H.264 that had no bits for the noise."""
    clock = Clock()
    script = [picture(1), *[picture(2)] * 9, picture(3), *[picture(4)] * 9, picture(5)]
    camera = ScriptedCamera(clock, iter(script))
    reader = LatestFrame(lambda: camera, clock)
    for _ in range(len(script) + 1):
        reader.step()
        clock.wait(0.1)
        assert reader.status().state != "frozen"
    assert reader.status().captured == 5


def test_a_file_may_repeat_its_picture() -> None:
    clock = Clock()
    camera = ScriptedCamera(clock, iter([picture(1)] * 50))
    camera.may_repeat = True
    reader = LatestFrame(lambda: camera, clock)
    for _ in range(51):
        reader.step()
    assert reader.status().captured == 50


def test_the_end_of_a_file_is_told_and_not_an_error() -> None:
    clock = Clock()
    reader, cameras = reader_of(clock, [picture(1)])
    for _ in range(5):
        reader.step()
    assert reader.status().state == "ended"
    assert cameras[0].opened == 1


def test_a_read_that_hangs_is_left_behind() -> None:
    clock = Clock()
    release, hanging = threading.Event(), threading.Event()

    class Hanging(ScriptedCamera):
        def read(self, timeout_s: float) -> Frame | None:
            hanging.set()
            release.wait(20.0)
            return None

    first = Hanging(clock, iter([]))
    second = ScriptedCamera(clock, iter([picture(i) for i in range(5)]), 0.0)
    waiting: Iterator[Camera] = iter([first, second])
    with LatestFrame(lambda: next(waiting), clock) as reader:
        assert hanging.wait(20.0)
        assert reader.take() is None
        clock.now_s += 9.0
        frame = reader.take(20.0)
        assert frame is not None
        assert frame.image[0, 0] <= 4
        assert reader.status().reopened == 1
        release.set()


class Stuck(ScriptedCamera):
    """Hangs in whatever ``hangs_in`` names, until it is let go."""

    def __init__(self, clock: Clock, hangs_in: str, let_go: threading.Event) -> None:
        super().__init__(clock, iter([CameraError("camera T: delivers no picture")]))
        self.hangs = threading.Event()
        self._hangs_in, self._let_go = hangs_in, let_go

    def _maybe(self, name: str) -> None:
        if self._hangs_in == name:
            self.hangs.set()
            assert self._let_go.wait(60.0)

    def open(self) -> None:
        self._maybe("open")
        super().open()

    def read(self, timeout_s: float) -> Frame | None:
        self._maybe("read")
        return super().read(timeout_s)

    def close(self) -> None:
        self._maybe("close")
        super().close()


class Held(ScriptedCamera):
    def open(self) -> None:
        raise CameraHeldError("camera T: /dev/videoT is busy", "another program uses it")


@pytest.mark.parametrize("hangs_in", ["open", "read", "close"])
def test_a_camera_that_an_own_hung_reading_holds_is_nobody_else_s_fault(hangs_in: str) -> None:
    clock, let_go = Clock(), threading.Event()
    stuck, held = Stuck(clock, hangs_in, let_go), Held(clock, iter([]))
    cameras: Iterator[Camera] = iter([stuck, *[held] * 1000])
    with LatestFrame(lambda: next(cameras), clock) as reader:
        assert stuck.hangs.wait(20.0)
        clock.now_s += 9.0
        assert "has hung for 9" in reader.status().reason, "the next thread may be quicker"
        assert wait_until(lambda: "may hold it" in reader.status().reason), reader.status()
        said = reader.status().reason
        assert "camera T: /dev/videoT is busy; Clearway's own earlier reading of it" in said
        assert "another program" not in said
        let_go.set()
        clock.now_s += 20.0
        assert wait_until(lambda: "another program uses it" in reader.status().reason)


def test_hung_readings_are_bounded_and_the_last_is_waited_for() -> None:
    clock, let_go = Clock(), threading.Event()
    opened: list[Stuck] = []

    def open_camera() -> Camera:
        opened.append(Stuck(clock, "open", let_go))
        return opened[-1]

    with LatestFrame(open_camera, clock) as reader:
        for count in range(1, 10):
            many = min(count, MOST_LEFT_BEHIND + 1)
            assert wait_until(lambda many=many: len(opened) == many and opened[-1].hangs.is_set())
            clock.now_s += 9.0
            status = reader.status()
        assert len(opened) == MOST_LEFT_BEHIND + 1
        assert "3 earlier ones hang: waiting for it" in status.reason
        let_go.set()
        assert wait_until(lambda: "delivers no picture" in reader.status().reason)


def test_the_thread_delivers_and_stops() -> None:
    clock = Clock()
    camera = ScriptedCamera(clock, iter([picture(i) for i in range(200)]))
    with LatestFrame(lambda: camera, clock) as reader:
        assert reader.take(20.0) is not None
    assert camera.closed >= 1
    assert reader.status().state == "closed"
