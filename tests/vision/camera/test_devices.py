"""Devices and addresses: drivers with a will of their own, and passwords that never show."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.vision.camera.scripted import Clock
from vision.camera import capture
from vision.camera.camera import Camera, CameraError
from vision.camera.sources import camera_for, driver_time_s, without_password


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
