"""What is plugged in, and by whom it may be used: names, metadata nodes, groups, udev's rule."""

from __future__ import annotations

import json

from tests.arena_pc.machine.pc import ArenaPC
from tests.arena_pc.machine.pictures import RAW_IS_SLOW, moving_disc
from tests.arena_pc.machine.programs import wait_for_files
from tests.arena_pc.machine.usb_sockets import ADAPTER, CAMERA, UsbSockets


def test_two_alike_cameras_and_adapters_are_told_apart_and_metadata_is_no_camera(
    pc: ArenaPC, usb: UsbSockets
) -> None:
    names = [CAMERA.format("C1"), CAMERA.format("C2"), ADAPTER.format("A1"), ADAPTER.format("A2")]
    for number in "12":
        usb.camera(moving_disc, RAW_IS_SLOW, f"C{number}")
        usb.adapter(f"A{number}")
    wait_for_files(pc, *names)
    listed = json.loads(pc.check("clearway devices --format json"))
    adapters = [one["path"] for one in listed["serial"] if "ttyUSB" in one["device"]]
    assert [one["path"] for one in listed["cameras"]] + adapters == names
    # the kernel has a node for the metadata of each: they are there, and are not listed
    assert pc.check("ls /dev/video* | wc -l").strip() == "4"


def test_a_plain_user_is_told_which_groups_are_needed_and_may_with_them(
    pc: ArenaPC, usb: UsbSockets
) -> None:
    usb.camera(moving_disc, RAW_IS_SLOW)
    usb.adapter("A1")
    wait_for_files(pc, CAMERA.format("C1"), ADAPTER.format("A1"))
    pc.check("useradd -m visitor; useradd -m -G video,dialout driver")

    def doctor(user: str) -> list[dict[str, str]]:
        told = pc.run(f"runuser -u {user} -- clearway doctor --format json", 180)
        findings: list[dict[str, str]] = json.loads(told.output)["findings"]
        return [one for one in findings if one["name"] in ("cameras", "serial ports")]

    for finding in doctor("visitor"):
        print(finding)
    for finding in doctor("driver"):
        print(finding)
    assert 0


def test_the_rule_for_udev_names_the_adapter_wherever_it_is_plugged_in(
    pc: ArenaPC, usb: UsbSockets
) -> None:
    first = usb.adapter("A1")
    wait_for_files(pc, ADAPTER.format("A1"))
    pc.write(
        "/etc/clearway/arena.yaml",
        "arena: {bounds_m: [0.0, 0.0, 2.4, 1.8]}\n"
        "robot: {marker_id: 7, marker_size_m: 0.09, marker_height_m: 0.12, radius_m: 0.09}\n"
        f"serial: {{port: {ADAPTER.format('A1')}}}\n",
    )
    print(pc.check("clearway install-service /etc/clearway/arena.yaml", 180))
    pc.check("udevadm control --reload && udevadm trigger --subsystem-match=tty && udevadm settle")
    look = "stat -L -c '%G %a' /dev/clearway-robot && realpath /dev/clearway-robot"
    assert pc.check(look).split() == ["dialout", "660", "/dev/ttyUSB0"]

    # its first name is still in use when it comes back, and another adapter is no robot
    pc.check("exec 9<>/dev/ttyUSB0; sleep 600 >/dev/null 2>&1 & disown")
    usb.unplug_adapter(first)
    usb.adapter("A1")
    usb.adapter("A2")
    wait_for_files(pc, "/dev/clearway-robot", ADAPTER.format("A2"))
    assert pc.check(look).split() == ["dialout", "660", "/dev/ttyUSB1"]
