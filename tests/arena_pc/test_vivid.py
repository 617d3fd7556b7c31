"""The kernel's own test camera: buffers with errors, a driver that fails, clocks that wrap."""

from __future__ import annotations

import re
from functools import partial

import pytest

from tests.arena_pc.machine.pc import ArenaPC
from tests.arena_pc.machine.programs import PATIENCE_S, Program, wait_for_files, watch_camera
from tests.support.waiting import wait_until

NODE = "/dev/video0"
FAULTS = {
    "inject_vidioc_qbuf_error=1": "the driver gives no picture: Invalid argument",
    "inject_fatal_streaming_error=1": "the driver gives no picture: Input/output error",
    "disconnect=1": r"unplugged \(/dev/video0 is gone\)",
    "percentage_of_dropped_buffers=100": "the camera delivers no picture",
}


@pytest.fixture
def vivid(pc: ArenaPC) -> ArenaPC:
    """A machine with that camera."""
    pc.check("modprobe vivid n_devs=1 node_types=0x1 input_types=0x00", 120)
    wait_for_files(pc, NODE)
    return pc


def control(pc: ArenaPC, setting: str) -> None:
    pc.check(f"v4l2-ctl -d {NODE} -c {setting}")


def more_than(reader: Program, before: int) -> bool:
    return captured(reader) > before


def captured(reader: Program) -> int:
    """How many pictures it has read by its last line."""
    return int(re.findall(r"^\w+ (\d+)", reader.said(), re.MULTILINE)[-1])


def test_what_fails_is_said_and_the_camera_is_opened_again(vivid: ArenaPC) -> None:
    reader = watch_camera(vivid, NODE, 10.0)
    reader.says("^running")
    for fault, words in FAULTS.items():
        before = len(reader.said())
        control(vivid, fault)
        reader.says(f"^lost .*{words}; trying again", after=before)
        control(vivid, "percentage_of_dropped_buffers=0")
        reader.says(f"(?s){words}.*^running", after=before)
    assert "Traceback" not in reader.said()


def test_a_damaged_picture_and_a_clock_that_wraps_do_not_end_the_stream(vivid: ArenaPC) -> None:
    """Its stamps are of another age than the program's clock."""
    control(vivid, "wrap_timestamp=1")
    reader = watch_camera(vivid, NODE, 10.0)
    reader.says("^running")
    for _ in range(3):
        control(vivid, "inject_v4l2_buf_flag_error=1")
        before = captured(reader)
        assert wait_until(partial(more_than, reader, before), PATIENCE_S)
    assert not re.search("^(lost|frozen|ended)|Traceback", reader.said(), re.MULTILINE)
