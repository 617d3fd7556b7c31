"""A USB camera under the kernel's own driver: what is chosen, what is set, and who has it."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from tests.arena_pc import arena
from tests.arena_pc.machine.pc import ArenaPC
from tests.arena_pc.machine.pictures import RAW_IS_SLOW, moving_disc
from tests.arena_pc.machine.programs import Program, wait_for_files, watch_camera
from tests.arena_pc.machine.usb_camera import UsbCamera
from tests.arena_pc.machine.usb_sockets import CAMERA, UsbSockets

NAME = CAMERA.format("C1")


@pytest.fixture
def camera(pc: ArenaPC, usb: UsbSockets) -> UsbCamera:
    """A camera with YUYV at 5 and MJPEG at 10 pictures a second."""
    camera = usb.camera(moving_disc, RAW_IS_SLOW)
    wait_for_files(pc, NAME)
    return camera


def watched(pc: ArenaPC, options: str) -> dict[str, Any]:
    """What `clearway camera` says of it."""
    told = pc.run(f"clearway camera {options} --seconds 3 --format json", 180)
    said: dict[str, Any] = json.loads(told.output)
    return said


def test_the_format_is_taken_that_reaches_the_rate_and_raw_where_it_does(
    pc: ArenaPC, camera: UsbCamera
) -> None:
    """OpenCV takes the raw pictures, and half the rate."""
    said = watched(pc, f"{NAME} --size 640x480 --rate 10")
    assert said["taken"] == "MJPG 640x480 at 10 frames/s"
    assert camera.chosen[-1] == ("MJPG", 640, 480, 10.0)
    said = watched(pc, f"{NAME} --size 640x480 --rate 5")
    assert said["taken"] == "YUYV 640x480 at 5 frames/s"
    assert camera.chosen[-1] == ("YUYV", 640, 480, 5.0)


def test_controls_are_set_and_a_refusal_is_told(pc: ArenaPC, camera: UsbCamera) -> None:
    camera.controls["gain"].obeys = False
    for name, text in arena.files():
        pc.write(name, text.replace("rate_hz: 10", "rate_hz: 5\n  exposure_ms: 10\n  gain: 20"))
    findings = watched(pc, arena.FILE)["findings"]
    settings = [one["sentence"] for one in findings if one["name"] == "settings"]
    assert any("asked for gain 20, the driver refuses" in one for one in settings), findings
    assert (camera.controls["exposure_mode"].value, camera.controls["exposure"].value) == (1, 100)
    assert camera.controls["gain"].value == camera.controls["gain"].default


def test_a_camera_that_falls_silent_or_hangs_is_named_and_comes_back(
    pc: ArenaPC, camera: UsbCamera
) -> None:
    reader = watch_camera(pc, NAME, 5.0)
    reader.says("^running")
    camera.is_silent = True
    silent = reader.says("delivers no picture")
    camera.is_silent = False
    reader.says("\nrunning", after=len(silent))
    before = len(reader.said())
    camera.is_hung = True
    hung = reader.says("^lost.*does not answer", after=before)
    assert "program" not in hung


def test_another_program_that_has_the_camera_is_named(pc: ArenaPC, camera: UsbCamera) -> None:
    other = Program(pc, f"v4l2-ctl -d {NAME} --stream-mmap --stream-count=1000000")
    other.says("<")
    told = pc.run(f"clearway camera {NAME} --seconds 3", 180)
    assert told.code == 2
    assert re.search(r"/dev/video0 is busy \(v4l2-ctl \(process \d+\) uses it\)", told.output)
