"""A camera that offers raw pictures at 10 and packed ones at 30 a second; decoding; a replug.

    python -m benchmarks.camera

Writes benchmarks/results/camera.md. The camera is the library that the tests preload: it answers
as a V4L2 driver does, and gives pictures at the rate that was agreed on. Decoding is timed in
processor time, colour and grey by turns. Needs gcc.
"""

from __future__ import annotations

import json
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from navigation.config import load_config
from navigation.run.world import World
from tests.support.processes.v4l2_preloaded import jpegs, run, video_nodes
from tests.support.processes.v4l2_replug import replug
from vision.camera.camera import Image
from vision.camera.v4l2.pixels import picture_of

ROOT = Path(__file__).parents[2]
RESULT = ROOT / "benchmarks" / "results" / "camera.md"
SIZE = (1280, 960)
MODES = "YUYV:1280x960@10@5,640x480@30;MJPG:1280x960@30@15,640x480@30"
ROUNDS = 200
AWAY_S = (0.2, 0.7, 1.5, 3.0, 6.0)

CLEARWAY = """
import json, sys, time
from navigation.config.sections import CameraSection
from navigation.run.devices.device_settings import device_settings
from vision.camera.v4l2.device import DeviceCamera
settings = device_settings(CameraSection(source=0))
camera = DeviceCamera(sys.argv[1], time.monotonic, 30.0, (1280, 960), settings)
began_s = time.monotonic()
camera.open()
times = [camera.read(5.0).captured_s for _ in range(150)]
told = {"first_s": times[0] - began_s, "rate_hz": (len(times) - 1) / (times[-1] - times[0])}
told["format"] = camera.mode.fourcc
camera.close()
print(json.dumps(told))
"""

OPENCV = """
import json, sys, time
import cv2
began_s = time.monotonic()
camera = cv2.VideoCapture()
size = [cv2.CAP_PROP_FRAME_WIDTH, 1280, cv2.CAP_PROP_FRAME_HEIGHT, 960]
camera.open(sys.argv[1], cv2.CAP_V4L2, size)
camera.set(cv2.CAP_PROP_FPS, 30)
times = []
while len(times) < 60:
    if camera.read()[0]:
        times.append(time.monotonic())
code = int(camera.get(cv2.CAP_PROP_FOURCC))
told = {"first_s": times[0] - began_s, "rate_hz": (len(times) - 1) / (times[-1] - times[0])}
told["format"] = code.to_bytes(4, "little").decode()
camera.release()
print(json.dumps(told))
"""


def rates() -> list[str]:
    """What Clearway and OpenCV by itself get of the same camera."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        (node,) = video_nodes(Path(folder), "video0")
        for name, program in (("Clearway", CLEARWAY), ("OpenCV by itself", OPENCV)):
            told = run(
                program, [node], node,
                V4L2_MODES=MODES, V4L2_DELIVER="1", V4L2_JPEGS=jpegs(Path(folder), SIZE),
            )  # fmt: skip
            rows.append(
                f"| {name} | {told['format']} | {told['rate_hz']:.1f} | {told['first_s']:.2f} |"
            )
    return rows


def arena() -> Image:
    """The simulated camera's picture, in colour as a webcam would give it."""
    world = World(load_config(ROOT / "configs" / "simulation.yaml", {}))
    try:
        camera = world.open_camera()
        camera.open()
        frame = camera.read(5.0)
    finally:
        world.stop()
    assert frame is not None
    tinted = cv2.cvtColor(frame.image, cv2.COLOR_GRAY2BGR).astype(np.float64)
    tinted *= (0.94, 1.0, 1.04)
    return np.clip(tinted, 0, 255).astype(np.uint8)


def decoding() -> list[str]:
    """Milliseconds of processor time for a picture of the arena, quality 85, 4:2:2 as webcams."""
    how = [cv2.IMWRITE_JPEG_QUALITY, 85]
    how += [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422]
    picture = arena()
    packed = cv2.imencode(".jpg", picture, how)[1].reshape(-1).astype(np.uint8, copy=False)
    raw = cv2.cvtColor(picture, cv2.COLOR_BGR2YUV_YUY2).reshape(-1).astype(np.uint8, copy=False)
    cases: dict[str, tuple[Any, str, bool]] = {
        "MJPG to grey": (packed, "MJPG", False),
        "MJPG to colour": (packed, "MJPG", True),
        "YUYV to grey": (raw, "YUYV", False),
    }
    took: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(ROUNDS):
        for name, (data, fourcc, colour) in cases.items():
            began_s = time.process_time()
            assert picture_of(data, fourcc, SIZE, 0, colour=colour) is not None
            took[name].append(1000.0 * (time.process_time() - began_s))
    return [
        f"| {name} | {len(cases[name][0]) / 1000.0:.0f} | {statistics.median(times):.2f} "
        f"| {np.percentile(times, 99):.2f} |"
        for name, times in took.items()
    ]


def replugs() -> list[str]:
    """Seconds from the plug to the first picture, after a camera was away for a while."""
    rows = []
    for away_s in AWAY_S:
        with tempfile.TemporaryDirectory() as folder:
            (node,) = video_nodes(Path(folder), "video0")
            for name, again in (("same", node), ("another", node.with_name("video4"))):
                told = replug(node, [again], away_s)
                rows.append(
                    f"| {away_s:g} | {name} | {told['lost_s']:.2f} | {told['back_s']:.2f} |"
                )
    return rows


def main() -> None:
    """Measure all, and write the page."""
    lines = [
        "# Cameras",
        "",
        "Made by `python -m benchmarks.camera`.",
        "",
        f"Asked for 1280x960 at 30 frames/s, of a camera that offers `{MODES}`,",
        "and halves its rate while automatic exposure may lower it (a dark room). Target: 30.",
        "",
        "| reader | format | frames/s | first picture s |",
        "|---|---|---|---|",
        *rates(),
        "",
        f"A picture of the arena, 1280x960; {ROUNDS} times by turns. Target: 4 ms.",
        "",
        "| what | kB | median ms | p99 ms |",
        "|---|---|---|---|",
        *decoding(),
        "",
        "A camera is pulled out and plugged in again. Target: 2 s to the first picture.",
        "",
        "| away s | name | noticed s | first picture s |",
        "|---|---|---|---|",
        *replugs(),
    ]
    RESULT.write_text("\n".join(lines) + "\n")
    print(json.dumps(lines[4:], indent=0))


if __name__ == "__main__":
    main()
