"""What is plugged in, and by whom it may be used: names, metadata nodes, groups, udev's rule."""

from __future__ import annotations

import json

from tests.arena_pc import arena
from tests.arena_pc.machine.pc import ArenaPC
from tests.arena_pc.machine.pictures import RAW_IS_SLOW, moving_disc
from tests.arena_pc.machine.programs import wait_for, wait_for_files
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


def test_a_plain_user_is_told_what_needs_which_group(pc: ArenaPC, usb: UsbSockets) -> None:
    camera, adapter = CAMERA.format("C1"), ADAPTER.format("A1")
    usb.camera(moving_disc, RAW_IS_SLOW)
    usb.adapter("A1")
    wait_for_files(pc, camera, adapter)
    pc.check("useradd -m visitor; useradd -m -G video,dialout driver")

    def plugged_in(user: str) -> dict[str, list[str]]:
        told = pc.run(f"runuser -u {user} -- clearway doctor --format json", 180)
        findings = json.loads(told.output)["findings"]
        names = ("cameras", "serial ports")
        found = [one for one in findings if one["name"] in names]
        assert all("usermod -aG" in one["cure"] for one in found if one["status"] != "ok")
        return {
            status: [one["sentence"] for one in found if one["status"] == status]
            for status in ("ok", "warn", "fail")
        }

    ports = f"/dev/ttyS0, {adapter}"
    refused = [f"{path}: no permission" for path in (camera, "/dev/ttyS0", adapter)]
    assert plugged_in("visitor") == {"ok": [camera, ports], "warn": refused, "fail": []}
    assert plugged_in("driver") == {"ok": [camera, ports], "warn": [], "fail": []}


def test_the_rule_for_udev_names_the_robots_adapter_wherever_it_is_plugged_in(
    pc: ArenaPC, usb: UsbSockets
) -> None:
    first = usb.adapter("A1")
    wait_for_files(pc, ADAPTER.format("A1"))
    for name, text in arena.files():
        pc.write(name, text)
    said = pc.check(f"clearway install-service {arena.FILE}", 180)
    assert "wrote /etc/udev/rules.d/70-clearway.rules" in said
    pc.check("udevadm control --reload && udevadm trigger --subsystem-match=tty && udevadm settle")
    look = "stat -L -c '%G %a' /dev/clearway-robot; realpath /dev/clearway-robot"
    assert pc.check(look).split() == ["dialout", "660", "/dev/ttyUSB0"]

    # its first name is still in use when it comes back, and another adapter is no robot
    pc.check("(sleep 600 <>/dev/ttyUSB0 >/dev/null 2>&1 &)")
    usb.unplug_adapter(first)
    usb.adapter("A2")
    wait_for_files(pc, ADAPTER.format("A2"))
    assert pc.run("test -e /dev/clearway-robot").code == 1
    usb.adapter("A1")
    wait_for(pc, look, "ttyUSB2")
    assert pc.check(look).split() == ["dialout", "660", "/dev/ttyUSB2"]
