"""OpenCV on a V4L2 camera that is not there: each program runs with the devices preloaded."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from vision.camera.latest_frame import WatchLimits

SOURCE = Path(__file__).parents[2] / "support" / "processes" / "v4l2_camera.c"

pytestmark = [
    pytest.mark.timed,
    pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc"),
]

READ = """
import json, sys, time
import cv2
cv2.VideoCapture()  # whatever OpenCV reads when it is loaded, it has read
from vision.camera.camera import CameraError
from vision.camera.capture import DeviceCamera
camera = DeviceCamera(sys.argv[1], time.monotonic, 20.0, (640, 480))
said = []
camera.open()
began_s = time.monotonic()
try:
    camera.read(0.5)
except CameraError as error:
    said.append(str(error))
print(json.dumps({"said": said, "took_s": time.monotonic() - began_s}))
"""

WATCH = """
import json, os, sys, time
from vision.camera.capture import DeviceCamera
from vision.camera.latest_frame import LatestFrame, WatchLimits
open_camera = lambda: DeviceCamera(sys.argv[1], time.monotonic, None, None)
said, end_s = [], time.monotonic() + 30.0
with LatestFrame(open_camera, time.monotonic, WatchLimits(hung_s=0.5)) as reader:
    while time.monotonic() < end_s and not any("may hold it" in one for one in said):
        reader.take(0.05)
        said.append(reader.status().reason)
print(json.dumps(said), flush=True)
os._exit(0)  # the hung thread ends with the process
"""

LIST = """
import json, sys
from vision.camera import capture
nodes = {"/dev/video*": sys.argv[1:]}
capture.glob.glob = lambda pattern: nodes.get(pattern, [])
refused = ""
try:
    capture.DeviceCamera(sys.argv[2], lambda: 0.0, None, None).open()
except capture.CameraError as error:
    refused = str(error)
print(json.dumps([[path for path, _ in capture.list_devices()], refused]))
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("v4l2") / "v4l2_camera.so"
    flags = ["-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    subprocess.run(["gcc", *flags, "-o", made, SOURCE, "-ldl"], check=True, timeout=60)
    return made


@pytest.fixture
def nodes(tmp_path: Path) -> tuple[Path, Path]:
    """The camera's paths: pictures, metadata."""
    for name in ("video0", "video1"):
        (tmp_path / name).touch()
    return tmp_path / "video0", tmp_path / "video1"


def run(library: Path, nodes: tuple[Path, Path], script: str, *arguments: Path, **more: str) -> Any:
    """What the script prints, in JSON; run with the devices and without a set timeout."""
    environment = {
        name: value
        for name, value in os.environ.items()
        if name != "OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT"
    }
    environment |= {"LD_PRELOAD": str(library), "V4L2_CAMERA": str(nodes[0])}
    environment |= {"V4L2_METADATA": str(nodes[1]), **more}
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_camera_that_delivers_nothing_is_a_failed_read_before_it_counts_as_hung(
    library: Path, nodes: tuple[Path, Path], tmp_path: Path
) -> None:
    """And the rate is asked for last: a format or a new buffer begins at the driver's own."""
    log = tmp_path / "log"
    told = run(library, nodes, READ, nodes[0], V4L2_LOG=str(log))
    assert told["said"] == [f"camera {nodes[0]}: the camera delivers no picture"]
    assert 4.5 < told["took_s"] < WatchLimits().hung_s - 1.0
    assert log.read_text().splitlines()[-1] == "rate 20"


def test_the_users_own_timeout_is_left_alone(library: Path, nodes: tuple[Path, Path]) -> None:
    told = run(library, nodes, READ, nodes[0], OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT="1")
    assert 0.5 < told["took_s"] < 4.0


def test_a_driver_that_hangs_is_not_said_to_be_in_use_by_another_program(
    library: Path, nodes: tuple[Path, Path]
) -> None:
    said = run(library, nodes, WATCH, nodes[0], V4L2_HANG_S="60")
    assert "is busy; Clearway's own earlier reading of it has hung for" in said[-1], said[-3:]
    assert not any("another program" in reason for reason in said)


def test_a_camera_s_metadata_node_is_no_camera(library: Path, nodes: tuple[Path, Path]) -> None:
    listed, refused = run(library, nodes, LIST, *nodes)
    assert listed == [str(nodes[0])]
    assert refused == (
        f"camera {nodes[1]}: {nodes[1]} gives no pictures; `clearway devices` lists what does"
    )
