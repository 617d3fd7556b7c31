"""Devices and addresses: drivers with a will of their own, and passwords that never show."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.vision.camera.scripted import Clock
from vision.camera.camera import CameraAbsentError, CameraError
from vision.camera.rate_remark import RateRemark
from vision.camera.sources import camera_for, driver_time_s, without_password
from vision.camera.v4l2 import device, devices
from vision.camera.v4l2.users import users_of, who_uses


def test_a_device_that_is_not_there_or_no_camera_is_told_of() -> None:
    with pytest.raises(CameraAbsentError, match="/dev/video987 does not exist; is it plugged in"):
        camera_for(987, clock=Clock()).open()
    with pytest.raises(CameraError, match="/dev/null gives no pictures"):
        camera_for("/dev/null", clock=Clock()).open()
    with pytest.raises(CameraError, match="read while closed"):
        camera_for("/dev/null", clock=Clock()).read(1.0)


@pytest.mark.parametrize("number", [errno.EIO, errno.ETIMEDOUT, errno.EPROTO, errno.EPIPE])
def test_a_camera_that_hangs_is_said_not_to_answer(
    number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Found on an emulated PC: "cannot be opened: Input/output error" was all that was said."""

    def hang(_path: str) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(device, "Node", hang)
    with pytest.raises(CameraError, match=r"does not answer \(.+\); unplug it and plug"):
        camera_for("/dev/null", clock=Clock()).open()


def test_other_programs_that_have_a_device_open_are_named(tmp_path: Path) -> None:
    device = tmp_path / "video0"
    device.touch()
    for number, name, opened in ((7, "guvcview", device), (8, "sh", tmp_path), (9, "own", device)):
        folder = tmp_path / "proc" / str(number)
        (folder / "fd").mkdir(parents=True)
        (folder / "comm").write_text(f"{name}\n")
        (folder / "fd" / "3").symlink_to(opened)
    (tmp_path / "proc" / "10").mkdir()  # another user's
    assert users_of(str(device), tmp_path / "proc", own=9) == ["guvcview (process 7)"]
    assert who_uses(str(tmp_path / "video1")) == "another program uses it"


def test_a_node_without_pictures_is_not_listed_to_a_user_who_may_not_open_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Found on a PC whose user was not in the group 'video': a camera's metadata was a camera."""
    # as udev wrote them of a UVC camera and its metadata; it has not looked at the third yet
    told = {"81:0": ":capture:", "81:1": ":"}
    for number in range(3):
        folder = tmp_path / "system" / f"video{number}"
        folder.mkdir(parents=True)
        (folder / "dev").write_text(f"81:{number}\n")
        (folder / "name").write_text(f"Camera {number}\n")
    (tmp_path / "udev").mkdir()
    for number_told, can in told.items():
        text = f"S:v4l/by-id/x\nE:ID_V4L_VERSION=2\nE:ID_V4L_CAPABILITIES={can}\nG:seat\n"
        (tmp_path / "udev" / f"c{number_told}").write_text(text)
    names = [str(tmp_path / f"video{number}") for number in range(3)]
    monkeypatch.setattr(devices, "nodes", lambda: names)
    monkeypatch.setattr(devices, "SYSTEM", tmp_path / "system")
    monkeypatch.setattr(devices, "UDEV", tmp_path / "udev")
    monkeypatch.setattr(devices, "gives_pictures", lambda _: None)
    assert devices.list_devices() == [(names[0], "Camera 0"), (names[2], "Camera 2")]


def test_a_rate_that_hovers_is_no_new_sentence_a_picture() -> None:
    remark = RateRemark(30.0)
    said = [remark.of(26.9 + 0.2 * (n % 3), n / 27.0) for n in range(27 * 50)]
    assert len(set(said)) <= 2, "26.9 is off, 27.1 and 27.3 are not yet right again"
    minutes = [remark.of(20.0 + 0.01 * (n % 100), 100.0 + n / 20.0) for n in range(20 * 600)]
    assert len(set(minutes)) <= 11
    assert remark.of(29.0, 1000.0) == ""
    assert RateRemark(None).of(3.0, 0.0) == ""
    assert RateRemark(30.0).of(0.0, 0.0) == ""


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


def test_no_value_of_a_camera_s_query_shows_in_a_message() -> None:
    shown = without_password("http://me:secret@host/x?t=s3cret&size=big;naked#s3cret")
    assert shown == "http://host/x?t=(left out)&size=(left out)&(left out)"
    assert without_password(shown) == shown


@given(st.floats(0.0, 1e6), st.floats(0.0, 1e6))
def test_a_driver_stamp_on_another_clock_is_not_believed(stamp_s: float, now_s: float) -> None:
    told = driver_time_s(1000.0 * stamp_s, now_s)
    assert told <= now_s
    assert now_s - told <= 0.5
