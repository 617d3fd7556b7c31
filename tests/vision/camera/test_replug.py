"""A camera that is pulled out and comes back, under another name, with its controls restored."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.vision.camera.preloaded import NEEDS_GCC, run, video_nodes

pytestmark = NEEDS_GCC

REPLUG = """
import json, os, pathlib, sys, time
from vision.camera.latest_frame import LatestFrame
from vision.camera.sources import DeviceSettings, KnownCamera
from vision.camera.v4l2.controls import CameraControls, list_controls
from vision.camera.v4l2.device import DeviceCamera
first, *later = sys.argv[1].split(":")
again = sys.argv[2].split(":")
known = KnownCamera(lambda: [path for path in (first, *later, *again) if os.path.exists(path)])
settings = DeviceSettings("auto", CameraControls(exposure_ms=7.0), False)
cameras = []

def open_camera():
    cameras.append(DeviceCamera(first, time.monotonic, 30.0, (640, 480), settings, known))
    return cameras[-1]

told = {"reasons": []}

def watch(reader, until, limit_s):
    began_s = time.monotonic()
    while time.monotonic() - began_s < limit_s:
        frame, status = reader.take(0.02), reader.status()
        if status.reason and status.reason not in told["reasons"]:
            told["reasons"].append(status.reason)
        if until(frame, status):
            return time.monotonic() - began_s
    return None

with LatestFrame(open_camera, time.monotonic) as reader:
    watch(reader, lambda frame, status: status.captured > 4, 20.0)
    pathlib.Path(first).unlink()
    os.environ["V4L2_FAULT"] = "enodev"
    told["lost_s"] = watch(reader, lambda frame, status: status.state == "lost", 20.0)
    watch(reader, lambda frame, status: False, float(sys.argv[3]))
    for path in again:
        pathlib.Path(path + ".new").touch()  # to open the path itself would open the camera
        os.rename(path + ".new", path)
    os.environ.update({"V4L2_FAULT": "", "V4L2_PLUG": "2", "V4L2_CAMERA": ":".join(again)})
    os.environ.update(json.loads(sys.argv[4]))
    told["back_s"] = watch(reader, lambda frame, status: frame is not None, 4.0)
    if told["back_s"] is not None:
        told["values"] = {one.name: one.value for one in list_controls(cameras[-1].node)}
print(json.dumps(told))
"""


def replug(first: Path, again: list[Path], away_s: float = 0.3, change: str = "{}") -> Any:
    names = ":".join(map(str, again))
    return run(REPLUG, [first], first, names, away_s, change, V4L2_DELIVER="1")


def test_a_camera_is_back_within_two_seconds_of_its_plug_and_set_again(tmp_path: Path) -> None:
    """However long it was away: a camera that is not there is looked for twice a second."""
    (node,) = video_nodes(tmp_path, "video0")
    told = replug(node, [node], away_s=4.0)
    assert told["lost_s"] < 2.0
    assert told["back_s"] < 2.0
    assert told["values"]["Exposure Time, Absolute"] == 70
    assert told["values"]["Auto Exposure"] == 1
    assert any("unplugged" in reason for reason in told["reasons"])


def test_a_camera_is_found_under_another_name(tmp_path: Path) -> None:
    (node,) = video_nodes(tmp_path, "video0")
    told = replug(node, [tmp_path / "video4"])
    assert told["back_s"] < 2.0
    assert told["reasons"][-1] == f"found again as {tmp_path / 'video4'}"


def test_another_camera_that_has_taken_its_name_is_refused(tmp_path: Path) -> None:
    (node,) = video_nodes(tmp_path, "video0")
    told = replug(node, [node], change='{"V4L2_CARD": "Another"}')
    assert told["back_s"] is None
    assert f"{node} is another camera (Another) than before (Fake camera)" in told["reasons"][-1]


def test_of_two_cameras_that_are_alike_none_is_guessed(tmp_path: Path) -> None:
    (node,) = video_nodes(tmp_path, "video0")
    told = replug(node, [tmp_path / "video4", tmp_path / "video5"])
    assert told["back_s"] is None
    assert "are alike, and neither is where the camera was" in told["reasons"][-1]


@pytest.mark.parametrize("others", [0, 1])
def test_of_two_cameras_that_are_alike_the_one_at_the_same_port_is_taken(
    tmp_path: Path, others: int
) -> None:
    (node,) = video_nodes(tmp_path, "video0")
    told = replug(node, [node, *[tmp_path / f"video{4 + n}" for n in range(others)]])
    assert told["back_s"] < 2.0
    assert not any("found again" in reason for reason in told["reasons"])
