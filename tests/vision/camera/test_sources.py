"""Pictures, folders and films as cameras: in order, at their rate, damaged, replaced, missing."""

from __future__ import annotations

import struct
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.vision.camera.scripted import Clock
from vision.camera.camera import Camera, CameraError
from vision.camera.latest_frame import LatestFrame
from vision.camera.sources import camera_for, read_picture


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
