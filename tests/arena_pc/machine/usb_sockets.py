"""What is plugged into the arena PC's USB sockets: cameras, and serial adapters with a line.

A camera's socket stays when it is unplugged, so that it can be plugged in again; an adapter's is
made with it.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

from tests.arena_pc.machine.pc import ArenaPC
from tests.arena_pc.machine.usb_camera import Picture, UsbCamera
from tests.arena_pc.machine.uvc_descriptors import PictureFormat

CAMERA = "/dev/v4l/by-id/usb-Clearway_test_Arena_Camera_{}-video-index0"
ADAPTER = "/dev/serial/by-id/usb-QEMU_QEMU_USB_SERIAL_{}-if00-port0"
"""Their stable names, by their serial numbers."""


class UsbSockets:
    """The USB side of a machine that runs."""

    def __init__(self, pc: ArenaPC) -> None:
        self._pc = pc
        self._numbers = itertools.count(1)
        self._cameras: list[UsbCamera] = []

    def camera(
        self, picture: Picture, formats: Sequence[PictureFormat], serial: str = "C1"
    ) -> UsbCamera:
        """Plug in a camera."""
        path = self._socket(name := f"camera{next(self._numbers)}")
        self._pc.qmp("device_add", driver="usb-redir", id=name, chardev=f"{name}-line")
        camera = UsbCamera(path, picture, formats, serial)
        self._cameras.append(camera)
        return camera

    def adapter(self, serial: str) -> str:
        """Plug in an FTDI serial adapter; the name by which it is unplugged."""
        self._socket(name := f"adapter{next(self._numbers)}")
        self._pc.qmp(
            "device_add",
            driver="usb-serial",
            id=name,
            chardev=f"{name}-line",
            serial=serial,
            **{"always-plugged": True},
        )
        return name

    def unplug_adapter(self, name: str) -> None:
        """Pull a serial adapter out."""
        self._pc.qmp("device_del", id=name)

    def close(self) -> None:
        """End the cameras' threads."""
        for camera in self._cameras:
            camera.unplug()

    def _socket(self, name: str) -> Path:
        path = self._pc.work / name
        address = {"type": "unix", "data": {"path": str(path)}}
        backend = {"type": "socket", "data": {"addr": address, "server": True, "wait": False}}
        self._pc.qmp("chardev-add", id=f"{name}-line", backend=backend)
        return path
