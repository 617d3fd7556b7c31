"""V4L2 cameras that are not there: each program runs with them preloaded."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.processes.v4l2_preloaded import NEEDS_GCC, jpegs, run, video_nodes
from vision.camera.latest_frame import WatchLimits
from vision.camera.v4l2 import controls, structs
from vision.camera.v4l2.device import FIRST_PICTURE_S

pytestmark = NEEDS_GCC

WEBCAM = "YUYV:1280x960@10,640x480@30;MJPG:1280x960@30@15,640x480@30"

READ = """
import json, os, sys, time
from vision.camera.camera import CameraError
from vision.camera.v4l2.controls import CameraControls, list_controls
from vision.camera.v4l2.device import DeviceCamera, DeviceSettings
told = {"said": "", "reasons": [], "stamps": [], "means": []}
asked = json.loads(sys.argv[2])
size, rate_hz, count = tuple(asked["size"]), asked["rate_hz"], asked["count"]
set_to = CameraControls(**asked["controls"]) if "controls" in asked else None
settings = DeviceSettings(asked.get("format", "auto"), set_to, asked.get("colour", False))
camera = DeviceCamera(sys.argv[1], time.monotonic, rate_hz, size, settings)
began_s = time.monotonic()
try:
    camera.open()
    told["mode"] = [camera.mode.fourcc, *camera.mode.size, camera.mode.rate_hz]
    told["reasons"].append(camera.reason)
    while len(told["means"]) < count:
        frame = camera.read(1.0)
        if frame is None:
            told["said"] = "none"
            break
        told["means"].append(round(float(frame.image.mean())))
        told["stamps"].append([frame.captured_s, time.monotonic()])
        told["shape"] = list(frame.image.shape)
        if camera.reason != told["reasons"][-1]:
            told["reasons"].append(camera.reason)
    told["values"] = {one.name: one.value for one in list_controls(camera.node)}
except CameraError as error:
    told["said"] = str(error)
told |= {"took_s": time.monotonic() - began_s, "damaged": camera.damaged, "rate_hz": camera.rate_hz}
camera.close()
print(json.dumps(told))
"""


@pytest.fixture
def node(tmp_path: Path) -> Path:
    return next(video_nodes(tmp_path, "video0"))


def read(node: Path, count: int, *, size: Any = (640, 480), asked: Any = None, **more: str) -> Any:
    """What a camera is and gives, asked for 30 pictures a second."""
    wish = {"size": size, "rate_hz": 30.0, "count": count, **(asked or {})}
    more = {"V4L2_DELIVER": "1", "V4L2_JPEGS": jpegs(node.parent, size), **more}
    return run(READ, [node], node, json.dumps(wish), **more)


def ordinary_rate_hz(told: Any) -> float:
    """Rate of most pictures: a computer that stands still meanwhile makes few of them late."""
    return float(1.0 / np.median(np.diff([captured_s for captured_s, _ in told["stamps"]])))


def test_the_structures_are_the_kernel_s(tmp_path: Path) -> None:
    names = [name for name in vars(structs) if re.fullmatch("[A-Z]+(_[A-Z]+)?", name)]
    header = Path("/usr/include/linux/videodev2.h")
    if not header.is_file():
        pytest.skip("needs the kernel's headers")
    asked = [name for name in names if f"VIDIOC_{name}" in header.read_text()]
    assert len(asked) == 18
    prints = "".join(f'printf("{name} %lu\\n", (unsigned long)VIDIOC_{name});' for name in asked)
    program = f"#include <linux/videodev2.h>\n#include <stdio.h>\nint main(void){{{prints}}}\n"
    (tmp_path / "sizes.c").write_text(program)
    gcc = shutil.which("gcc")
    assert gcc is not None
    subprocess.run([gcc, "-o", tmp_path / "sizes", tmp_path / "sizes.c"], check=True, timeout=60)
    told = subprocess.run([tmp_path / "sizes"], capture_output=True, text=True, check=True).stdout
    assert dict(line.split() for line in told.splitlines()) == {
        name: str(getattr(structs, name)) for name in asked
    }


def test_mjpeg_is_taken_where_raw_pictures_are_too_slow(node: Path) -> None:
    told = read(node, 40, size=(1280, 960), asked={"controls": {}}, V4L2_MODES=WEBCAM)
    assert told["mode"] == ["MJPG", 1280, 960, 30.0]
    assert told["shape"] == [960, 1280], "decoded to grey"
    assert all(min(abs(mean - each) for each in (60, 90, 120)) <= 1 for mean in told["means"])
    slow = re.compile(r"asked for 30 frames/s, gets \d+\.\d")  # a busy computer decodes fewer
    assert [reason for reason in told["reasons"] if not slow.fullmatch(reason)] == [""]


def test_raw_pictures_are_taken_where_they_are_fast_enough(node: Path) -> None:
    told = read(node, 3, V4L2_MODES=WEBCAM)
    assert told["mode"] == ["YUYV", 640, 480, 30.0]
    assert set(told["means"]) <= set(range(50, 60)), "the Y of YUYV as it is"
    assert read(node, 3, asked={"colour": True}, V4L2_MODES=WEBCAM)["shape"] == [480, 640, 3]


def test_format_size_rate_and_controls_are_set_in_this_order(node: Path) -> None:
    log = node.parent / "log"
    asked = {"controls": {"exposure_ms": 5.0, "gain": 20.0, "focus": 35.0, "mains_hz": 60}}
    told = read(node, 2, asked=asked, V4L2_MODES=WEBCAM, V4L2_LOG=str(log))
    lines = log.read_text().splitlines()
    yuyv = int.from_bytes(b"YUYV", "little")
    assert lines[:3] == [f"format {yuyv}", "rate 30", "Power Line Frequency 2"]
    assert lines.index("Auto Exposure 1") < lines.index("Exposure Time, Absolute 50")
    assert lines.index("Focus, Automatic Continuous 0") < lines.index("Focus, Absolute 35")
    assert told["values"]["Gain"] == 20
    assert told["reasons"] == [""]


def test_automatic_exposure_does_not_halve_the_rate(node: Path) -> None:
    slow = read(node, 20, V4L2_MODES=WEBCAM)
    assert ordinary_rate_hz(slow) == pytest.approx(15.0, rel=0.2), "as the camera is by itself"
    fast = read(node, 20, asked={"controls": {}}, V4L2_MODES=WEBCAM)
    assert ordinary_rate_hz(fast) == pytest.approx(30.0, rel=0.2)


def test_a_format_that_is_asked_for_is_taken_or_refused(node: Path) -> None:
    told = read(node, 2, asked={"format": "mjpg"}, V4L2_MODES=WEBCAM)
    assert told["mode"][0] == "MJPG"
    told = read(node, 2, asked={"format": "grey"}, V4L2_MODES=WEBCAM)
    assert told["said"] == f"camera {node}: asked for format grey, the camera offers YUYV, MJPG"
    told = read(node, 2, V4L2_MODES="H264:640x480@30")
    assert "asked for a format that Clearway reads, the camera offers H264" in told["said"]


def test_packed_pictures_are_taken_where_usb_has_no_room_for_raw_ones(node: Path) -> None:
    told = read(node, 2, V4L2_MODES=WEBCAM, V4L2_NOSPACE="YUYV")
    assert told["mode"][0] == "MJPG"
    told = read(node, 2, asked={"format": "yuyv"}, V4L2_MODES=WEBCAM, V4L2_NOSPACE="YUYV")
    assert "USB has no room for its pictures; plug it into another port" in told["said"]


def test_what_a_driver_refuses_or_does_not_do_is_said(node: Path) -> None:
    asked = {"controls": {"exposure_ms": 5.0, "gain": 999.0, "white_balance_k": 5005.0}}
    refused = read(node, 2, asked=asked, V4L2_REFUSE=hex(controls.EXPOSURE))
    assert (
        "asked for exposure_ms 5, the driver refuses (Input/output error)" in refused["reasons"][0]
    )
    assert "asked for gain 999, the camera has 0 to 255" in refused["reasons"][0]
    assert refused["values"]["White Balance Temperature"] in (5000, 5010), "its steps are of 10 K"
    stuck = read(node, 2, asked=asked, V4L2_STUCK=hex(controls.EXPOSURE))
    assert "asked for exposure_ms 5, the driver gives 25" in stuck["reasons"][0]
    other = read(node, 2, size=(800, 600), V4L2_MODES=WEBCAM)
    assert "asked for 800x600 pixels, the driver gives 640x480" in other["reasons"][0]


def test_a_rate_that_is_not_kept_is_said_once(node: Path) -> None:
    told = read(node, 60, asked={"controls": {}}, V4L2_MODES=WEBCAM, V4L2_REAL_HZ="20")
    assert len(told["reasons"]) == 2
    assert re.fullmatch(r"asked for 30 frames/s, gets (19|20|21)\.\d", told["reasons"][1])


@pytest.mark.parametrize("fault", ["error", "cut"])
@pytest.mark.parametrize("mode", ["YUYV:640x480@30", "MJPG:640x480@30"])
def test_damaged_pictures_are_dropped_and_counted(node: Path, fault: str, mode: str) -> None:
    told = read(node, 20, asked={"controls": {}}, V4L2_MODES=mode, V4L2_FAULT=fault, V4L2_EVERY="4")
    assert len(told["means"]) == 20
    assert 6 <= told["damaged"] <= 10, "a busy computer passes over good ones"
    good = {50 + n for n in range(40)} | {59, 60, 89, 90, 119, 120}
    assert set(told["means"]) <= good


def test_a_camera_that_gives_only_damaged_pictures_has_failed(node: Path) -> None:
    asked = {"rate_hz": 200.0, "controls": {}}
    told = read(node, 9, asked=asked, V4L2_MODES="MJPG:640x480@200", V4L2_FAULT="error")
    assert told["said"] == "none", "for the moment: one reading passes over five"
    assert told["damaged"] == 5


def test_buffer_errors_and_an_unplugged_camera_are_failed_reads(node: Path) -> None:
    told = read(node, 9, V4L2_MODES=WEBCAM, V4L2_FAULT="eio")
    assert told["said"] == f"camera {node}: the driver gives no picture: Input/output error"
    told = read(node, 9, V4L2_MODES=WEBCAM, V4L2_FAULT="enodev")
    assert told["said"] == f"camera {node}: unplugged ({node} is gone)"


@pytest.mark.parametrize("fault", ["wrap", "future"])
def test_stamps_of_no_clock_are_replaced_by_the_arrival(node: Path, fault: str) -> None:
    told = read(node, 10, asked={"controls": {}}, V4L2_MODES=WEBCAM, V4L2_FAULT=fault)
    for stamp_s, read_s in told["stamps"]:
        assert 0.0 <= read_s - stamp_s < 2.0, "the false ones are 3 s off, or years"
    stamps = [stamp_s for stamp_s, _ in told["stamps"]]
    assert stamps == sorted(stamps)


def test_a_camera_that_delivers_nothing_is_a_failed_read_before_it_counts_as_hung(
    node: Path,
) -> None:
    told = read(node, 1, V4L2_FAULT="hang")
    assert told["said"] == f"camera {node}: the camera delivers no picture"
    assert told["took_s"] > 4.5
    assert WatchLimits().hung_s - 1.0 > FIRST_PICTURE_S


WATCH = """
import json, os, sys, time
from vision.camera.latest_frame import LatestFrame, WatchLimits
from vision.camera.v4l2.device import DeviceCamera
open_camera = lambda: DeviceCamera(sys.argv[1], time.monotonic, None, None)
said, end_s = [], time.monotonic() + 30.0
with LatestFrame(open_camera, time.monotonic, WatchLimits(hung_s=0.5)) as reader:
    while time.monotonic() < end_s and not any("may hold it" in one for one in said):
        reader.take(0.05)
        said.append(reader.status().reason)
print(json.dumps(said), flush=True)
os._exit(0)  # the hung thread ends with the process
"""


def test_a_driver_that_hangs_is_not_said_to_be_in_use_by_another_program(node: Path) -> None:
    said = run(WATCH, [node], node, V4L2_HANG_S="60", V4L2_DELIVER="1")
    assert "is busy; Clearway's own earlier reading of it has hung for" in said[-1], said[-3:]
    assert not any("another program" in reason for reason in said)


STALL = """
import json, os, sys, time
from vision.camera.latest_frame import LatestFrame
from vision.camera.v4l2.device import DeviceCamera
open_camera = lambda: DeviceCamera(sys.argv[1], time.monotonic, None, None)
told = {}
with LatestFrame(open_camera, time.monotonic) as reader:
    end_s = time.monotonic() + 20.0
    while time.monotonic() < end_s and reader.status().captured < 5:
        reader.take(0.05)
    os.environ["V4L2_FAULT"] = "hang"
    began_s = time.monotonic()
    while time.monotonic() < end_s and reader.status().state == "running":
        reader.take(0.05)
    told["noticed_s"], told["said"] = time.monotonic() - began_s, reader.status().reason
    os.environ["V4L2_FAULT"] = ""
    began_s = time.monotonic()
    while time.monotonic() < end_s and reader.take(0.05) is None:
        pass
    told["back_s"] = time.monotonic() - began_s
print(json.dumps(told))
"""


def test_a_camera_that_falls_silent_is_noticed_in_a_second_and_opened_again(node: Path) -> None:
    told = run(STALL, [node], node, V4L2_DELIVER="1")
    assert told["noticed_s"] < 2.5, told
    assert "no picture for" in told["said"]
    assert told["back_s"] < 3.0, told


LIST = """
import json, sys
from vision.camera.v4l2 import device, devices
devices.nodes = lambda: sys.argv[1:]
refused = ""
try:
    device.DeviceCamera(sys.argv[2], lambda: 0.0, None, None).open()
except device.CameraError as error:
    refused = str(error)
print(json.dumps([[path for path, _ in devices.list_devices()], refused]))
"""


def test_a_camera_s_metadata_node_is_no_camera(tmp_path: Path) -> None:
    pictures, metadata = video_nodes(tmp_path, "video0", "video1")
    listed, refused = run(LIST, [pictures], pictures, metadata, V4L2_METADATA=str(metadata))
    assert listed == [str(pictures)]
    assert refused == (
        f"camera {metadata}: {metadata} gives no pictures; `clearway devices` lists what does"
    )
