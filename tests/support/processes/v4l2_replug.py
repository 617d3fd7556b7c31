"""A program that reads a preloaded camera, has it pulled out, and plugged in again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.support.processes.v4l2_preloaded import run

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
