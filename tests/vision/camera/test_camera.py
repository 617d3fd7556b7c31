"""Frames, sources and the latest-frame reader, with a clock that the tests turn by hand."""

from __future__ import annotations

import struct
import threading
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.waiting import wait_until
from vision.camera import capture
from vision.camera.camera import Camera, CameraError, CameraHeldError, Frame, RateMeter, SourceState
from vision.camera.latest_frame import MOST_LEFT_BEHIND, LatestFrame, WatchLimits
from vision.camera.sources import camera_for, driver_time_s, read_picture, without_password


class Clock:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s

    def wait(self, pause_s: float) -> None:
        self.now_s += pause_s


def picture(value: int) -> np.ndarray:
    return np.full((8, 8), value % 256, np.uint8)


Event = np.ndarray | None | CameraError


class ScriptedCamera:
    """Gives, read after read, what a script says: a picture, nothing, or an error."""

    may_repeat = False
    rate_hz = 30.0
    reason = ""
    name = "camera T"

    def __init__(self, clock: Clock, script: Iterator[Event], step_s: float = 0.1) -> None:
        self._clock, self._script, self._step_s = clock, script, step_s
        self.state: SourceState = "closed"
        self.opened = self.closed = 0

    def open(self) -> None:
        self.opened += 1
        self.state = "running"

    def read(self, timeout_s: float) -> Frame | None:
        self._clock.now_s += self._step_s
        event = next(self._script, "end")
        if isinstance(event, str):
            self.state, self.reason = "ended", "no more"
            return None
        if isinstance(event, CameraError):
            raise event
        return None if event is None else Frame(event, self._clock.now_s, 0, self.name)

    def close(self) -> None:
        self.closed += 1
        self.state = "closed"


def reader_of(clock: Clock, *scripts: list[Event]) -> tuple[LatestFrame, list[ScriptedCamera]]:
    cameras = [ScriptedCamera(clock, iter(s)) for s in scripts]
    waiting = iter(cameras)
    return LatestFrame(lambda: next(waiting), clock), cameras


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


def save(path: Path, value: int) -> Path:
    cv2.imwrite(str(path), np.full((12, 16), value, np.uint8))
    return path


def test_a_folder_gives_its_pictures_in_the_order_of_their_names(tmp_path: Path) -> None:
    for name, value in (("b.png", 20), ("a.png", 10), ("c.png", 30)):
        save(tmp_path / name, value)
    (tmp_path / "notes.txt").write_text("no picture")
    camera = camera_for(str(tmp_path), clock=Clock(), paced=False)
    camera.open()
    frames = [camera.read(1.0) for _ in range(3)]
    assert [int(f.image[0, 0]) for f in frames if f is not None] == [10, 20, 30]
    assert camera.read(1.0) is None
    assert camera.state == "ended"
    camera.close()


def test_a_picture_is_shown_for_ever_at_the_rate_asked_for(tmp_path: Path) -> None:
    clock = Clock()
    path = save(tmp_path / "a.png", 50)
    camera = camera_for(str(path), clock=clock, rate_hz=20.0, wait=clock.wait)
    camera.open()
    frames = [camera.read(1.0) for _ in range(40)]
    assert all(f is not None and f.image[0, 0] == 50 for f in frames)
    assert camera.rate_hz == pytest.approx(20.0)
    assert camera.may_repeat


def test_a_paced_file_gives_nothing_before_its_time(tmp_path: Path) -> None:
    clock = Clock()
    path = save(tmp_path / "a.png", 50)
    camera = camera_for(str(path), clock=clock, rate_hz=1.0, wait=clock.wait)
    camera.open()
    assert camera.read(0.1) is not None
    assert camera.read(0.1) is None
    assert clock.now_s == pytest.approx(100.1)
    assert camera.read(2.0) is not None
    assert clock.now_s == pytest.approx(101.0)


def test_a_video_plays_ends_and_loops(tmp_path: Path) -> None:
    path = tmp_path / "film.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, (64, 48), False)
    if not writer.isOpened():
        pytest.skip("this OpenCV writes no MJPG video")
    for value in (40, 120, 200):
        writer.write(np.full((48, 64), value, np.uint8))
    writer.release()
    clock = Clock()
    camera = camera_for(str(path), clock=clock, wait=clock.wait)
    camera.open()
    frames = [camera.read(1.0) for _ in range(3)]
    greys = [int(f.image.mean()) for f in frames if f is not None]
    assert greys == pytest.approx([40, 120, 200], abs=4)
    assert camera.rate_hz == pytest.approx(25.0)
    assert camera.read(1.0) is None
    assert camera.state == "ended"
    camera.close()
    camera = camera_for(str(path), clock=clock, loop=True, paced=False)
    camera.open()
    assert all(camera.read(1.0) is not None for _ in range(8))
    camera.close()


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("nowhere.png", "no such file"),
        ("/dev/video991", "plugged in"),
        ("991", "plugged in"),
    ],
)
def test_a_missing_source_is_named(source: str, message: str) -> None:
    with pytest.raises(CameraError, match=message):
        camera_for(source, clock=Clock()).open()


def test_a_film_of_a_camera_held_otherwise_keeps_its_sensor_s_pixels(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 25.0, (64, 48))
    assert writer.isOpened()
    writer.write(np.full((48, 64, 3), 120, np.uint8))
    writer.release()
    data = bytearray(path.read_bytes())
    # The matrix of the track header (ISO 14496-12, 8.3.2): a quarter turn.
    at = data.index(b"tkhd") + 44
    one = 1 << 16
    data[at : at + 36] = struct.pack(">9i", 0, one, 0, -one, 0, 0, 48 * one, 0, 1 << 30)
    path.write_bytes(data)
    assert cv2.VideoCapture(str(path)).read()[1].shape == (64, 48, 3)  # as players show it
    camera = camera_for(str(path), clock=Clock(), paced=False)
    camera.open()
    frame = camera.read(1.0)
    assert frame is not None
    assert frame.image.shape == (48, 64, 3)
    camera.close()


def test_what_is_no_picture_and_no_video_is_refused(tmp_path: Path) -> None:
    empty, junk, text = tmp_path / "e.png", tmp_path / "j.png", tmp_path / "t.avi"
    empty.write_bytes(b"")
    junk.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(200)))
    text.write_text("not a video")
    with pytest.raises(CameraError, match="empty file"):
        read_picture(empty)
    with pytest.raises(CameraError, match="not a picture"):
        read_picture(junk)
    with pytest.raises(CameraError, match="neither a picture nor a video"):
        camera_for(str(text), clock=Clock()).open()
    folder = tmp_path / "f"
    folder.mkdir()
    with pytest.raises(CameraError, match="without pictures"):
        camera_for(str(folder), clock=Clock()).open()


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"rate_hz": 0.0}, "rate_hz"),
        ({"rate_hz": float("nan")}, "rate_hz"),
        ({"size": (0, 5)}, "size"),
    ],
)
def test_impossible_wishes_are_refused(how: dict[str, float], message: str) -> None:
    with pytest.raises(CameraError, match=message):
        camera_for("0", clock=Clock(), **how)  # type: ignore[arg-type]


class Driver:
    """Stands for OpenCV's capture of a device: promises 30 frames/s at 640x480, whatever asked."""

    opens = True
    frames = 1000

    def __init__(self) -> None:
        self.left = self.frames

    def open(self, target: str, backend: int, parameters: list[int]) -> bool:
        return self.opens

    def set(self, key: int, value: float) -> bool:
        return False

    def get(self, key: int) -> float:
        promised = {
            cv2.CAP_PROP_FRAME_WIDTH: 640.0,
            cv2.CAP_PROP_FRAME_HEIGHT: 480.0,
            cv2.CAP_PROP_FPS: 30.0,
        }
        return promised.get(key, 0.0)

    def grab(self) -> bool:
        self.left -= 1
        return self.left >= 0

    def retrieve(self) -> tuple[bool, np.ndarray]:
        return True, np.full((4, 4, 3), self.left % 256, np.uint8)

    def release(self) -> None:
        self.left = 0


def device(monkeypatch: pytest.MonkeyPatch, clock: Clock, **how: float) -> Camera:
    monkeypatch.setattr(cv2, "VideoCapture", Driver)
    return camera_for("/dev/null", clock=clock, **how)  # type: ignore[arg-type]


def test_a_driver_that_ignores_what_was_asked_is_told_of(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock()
    camera = device(monkeypatch, clock, rate_hz=60.0, size=(1920, 1080))  # type: ignore[arg-type]
    camera.open()
    assert "asked for 1920x1080 pixels, the driver gives 640x480" in camera.reason
    assert "asked for 60 frames/s, the driver promises 30" in camera.reason
    for _ in range(40):
        clock.now_s += 1.0 / 15.0
        frame = camera.read(1.0)
        assert frame is not None
        assert frame.captured_s == clock.now_s
    assert camera.reason == "asked for 60 frames/s, gets 15.0"
    assert camera.rate_hz == pytest.approx(15.0)
    assert not camera.may_repeat
    camera.close()
    with pytest.raises(CameraError, match="read while closed"):
        camera.read(1.0)


def test_a_busy_and_an_unplugged_device_are_told_of(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Driver, "opens", False)
    with pytest.raises(CameraError, match="/dev/null gives no pictures"):
        device(monkeypatch, Clock()).open()
    monkeypatch.setattr(capture, "gives_pictures", lambda _path: True)
    with pytest.raises(CameraError, match=r"/dev/null is busy \(another program uses it\)"):
        device(monkeypatch, Clock()).open()
    monkeypatch.setattr(Driver, "opens", True)
    monkeypatch.setattr(Driver, "frames", 1)
    camera = device(monkeypatch, Clock())
    camera.open()
    assert camera.read(1.0) is not None
    with pytest.raises(CameraError, match="camera /dev/null: the camera delivers no picture"):
        camera.read(1.0)


def test_a_stream_that_nobody_serves_is_told_of_without_its_password() -> None:
    camera = camera_for("http://me:secret@127.0.0.1:9/none.mjpg", clock=Clock())
    with pytest.raises(CameraError, match="no stream there") as caught:
        camera.open()
    assert "secret" not in str(caught.value)


def test_a_password_never_shows_in_a_message() -> None:
    assert without_password("rtsp://me:secret@host:554/live") == "rtsp://host:554/live"
    assert without_password("http://host/a@b") == "http://host/a@b"
    assert without_password("http://host:80/a@b") == "http://host:80/a@b"
    assert without_password("rtsp://me:se/cr@et@host/live") == "rtsp://host/live"
    assert without_password("arena.png") == "arena.png"


@given(st.floats(0.0, 1e6), st.floats(0.0, 1e6))
def test_a_driver_stamp_on_another_clock_is_not_believed(stamp_s: float, now_s: float) -> None:
    told = driver_time_s(1000.0 * stamp_s, now_s)
    assert told <= now_s
    assert now_s - told <= 0.5


def read_all(camera: Camera, reads: int) -> list[int]:
    """The values of the pictures that so many reads gave."""
    frames = [camera.read(1.0) for _ in range(reads)]
    return [int(frame.image[0, 0]) for frame in frames if frame is not None]


@pytest.mark.parametrize("paced", [True, False])
def test_a_damaged_picture_of_a_folder_is_left_out_and_named(tmp_path: Path, paced: bool) -> None:
    for name, value in (("a.png", 10), ("b.png", 20), ("c.png", 30)):
        save(tmp_path / name, value)
    (tmp_path / "b.png").write_bytes(b"no picture")
    clock = Clock()
    reader = LatestFrame(
        lambda: camera_for(str(tmp_path), clock=clock, paced=paced, wait=clock.wait), clock
    )
    values = []
    while reader.status().state != "ended":
        reader.step()
        assert reader.status().state in ("starting", "running", "ended")
        frame = reader.take()
        if frame is not None:
            values.append(int(frame.image[0, 0]))
            named = f"{tmp_path / 'b.png'}: not a picture"
            assert reader.status().reason.startswith(named) == (values[-1] == 30)
    assert values == [10, 30]
    assert reader.status().reopened == 0


def test_a_picture_that_is_still_being_written_is_waited_for(tmp_path: Path) -> None:
    clock = Clock()
    save(tmp_path / "a.png", 10)
    whole = save(tmp_path / "b.png", 20).read_bytes()
    (tmp_path / "b.png").write_bytes(whole[:60])
    camera = camera_for(str(tmp_path), clock=clock, wait=clock.wait)
    camera.open()
    assert read_all(camera, 3) == [10]
    (tmp_path / "b.png").write_bytes(whole)
    assert read_all(camera, 1) == [20]
    assert camera.reason == ""


@pytest.mark.parametrize("loop", [True, False])
def test_pictures_that_come_into_a_folder_meanwhile_are_read_too(
    tmp_path: Path, loop: bool
) -> None:
    save(tmp_path / "b.png", 20)
    camera = camera_for(str(tmp_path), clock=Clock(), paced=False, loop=loop)
    camera.open()
    assert read_all(camera, 1) == [20]
    save(tmp_path / "c.png", 30)
    save(tmp_path / "a.png", 10)
    assert read_all(camera, 4) == ([30, 10, 20, 30] if loop else [30])
    assert camera.state == ("running" if loop else "ended")


def test_a_folder_of_which_nothing_can_be_read_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"no picture")
    clock = Clock()
    camera = camera_for(str(tmp_path), clock=clock, wait=clock.wait, loop=True)
    camera.open()
    with pytest.raises(CameraError, match=r"none of its pictures can be read; .*a\.png: not a"):
        read_all(camera, 30)


def test_a_picture_that_is_replaced_is_shown_anew(tmp_path: Path) -> None:
    clock = Clock()
    path = save(tmp_path / "a.png", 50)
    camera = camera_for(str(path), clock=clock, wait=clock.wait)
    camera.open()
    first, again = camera.read(1.0), camera.read(1.0)
    assert first is not None
    assert again is not None
    assert np.shares_memory(again.image, first.image)  # decoded once
    save(tmp_path / "b.png", 90).replace(path)
    assert read_all(camera, 2) == [90, 90]
    path.write_bytes(b"half of it")
    assert read_all(camera, 1) == [90]
    said = f"{path}: not a picture that OpenCV can decode: the picture before it is shown"
    assert camera.reason == said
    path.unlink()
    assert read_all(camera, 1) == [90]
    assert "cannot be read" in camera.reason
    save(path, 120)
    assert read_all(camera, 1) == [120]
    assert camera.reason == ""


@pytest.mark.parametrize("source", ["", "  "])
def test_a_source_without_a_name_is_not_the_present_folder(
    source: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save(tmp_path / "a.png", 50)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(CameraError, match="source is empty: must be a number, a device"):
        camera_for(source, clock=Clock())
    assert camera_for(".", clock=Clock()).name == "."


def test_an_address_of_an_unknown_kind_is_no_file_and_keeps_its_password() -> None:
    with pytest.raises(CameraError, match="htp://host/x: must begin with one of rtsp://") as caught:
        camera_for("htp://me:secret@host/x", clock=Clock())
    assert "secret" not in str(caught.value)
    with pytest.raises(CameraError, match="rate_hz") as caught:
        camera_for("rtsp://me:secret@host/x", clock=Clock(), rate_hz=-1.0)
    assert "secret" not in str(caught.value)
