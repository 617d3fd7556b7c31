"""The C firmware in this process and in virtual time, through ctypes.

``CRobot`` has the face of ``RobotConnection`` (and, as ``controller``, what the loops use of
``RobotController``), so that every scenario runs on both.
"""

from __future__ import annotations

import ctypes
import functools
import shutil
import struct
import subprocess
import tempfile
from pathlib import Path

from firmware_protocol.robot.connection import Identity
from firmware_protocol.robot.controller import EIGHTHS_PER_M, WheelSpeeds
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.framing import MAX_WIRE
from firmware_protocol.wire.messages import SCHEMA_HASH, RobotState, StopReason

FIRMWARE = Path(__file__).parents[3] / "firmware_protocol" / "firmware"


class View(ctypes.Structure):
    """``cw_view`` of port_inprocess.c."""

    _fields_ = (
        *((name, ctypes.c_uint32) for name in ("mission", "accept_next", "exec_next")),
        *((name, ctypes.c_uint32) for name in ("prefix_crc", "exec_crc")),
        *((name, ctypes.c_int32) for name in ("x_um", "y_um", "heading")),
        *((name, ctypes.c_int16) for name in ("left", "right")),
        *((name, ctypes.c_uint16) for name in ("session_errors", "session_number")),
        *((name, ctypes.c_uint8) for name in ("state", "reason", "credit", "powered", "done")),
        *((name, ctypes.c_uint8) for name in ("expected", "has_session", "phase")),
    )


def missing_tool() -> str | None:
    """The compiler that is missing, None where there is one."""
    return None if shutil.which("gcc") and shutil.which("make") else "gcc and make"


@functools.cache
def library() -> ctypes.CDLL:
    """Build the firmware as a shared library, once a process."""
    folder = tempfile.TemporaryDirectory(prefix="clearway_twin_")
    command = ["make", "-s", "-C", str(FIRMWARE), "twin", f"BUILD={folder.name}"]
    subprocess.run(command, check=True, timeout=120)
    loaded = ctypes.CDLL(str(Path(folder.name) / "libclearway_twin.so"))
    folder.cleanup()
    loaded.cw_twin_size.restype = ctypes.c_size_t
    loaded.cw_twin_robot_size.restype = ctypes.c_size_t
    loaded.cw_twin_next_frame.restype = ctypes.c_uint8
    loaded.cw_crc32c.restype = ctypes.c_uint32
    return loaded


def _us(now_s: float) -> int:
    return round(now_s * 1e6) & 0xFFFFFFFF


class CRobot:
    """One robot in C."""

    def __init__(self, identity: Identity, settings: DriveSettings | None = None) -> None:
        self.identity = identity
        self._lib = library()
        self._memory = ctypes.create_string_buffer(self._lib.cw_twin_size())
        track_um, *others = (settings or DriveSettings()).whole_numbers()
        self._settings = struct.pack(f"=I{len(others)}H", track_um, *others)
        self._out = ctypes.create_string_buffer(MAX_WIRE)
        self._view = View()
        self._lib.cw_twin_init(
            self._memory,
            ctypes.c_uint32(identity.boot_id),
            ctypes.c_uint8(identity.reset_cause),
            ctypes.c_uint32(identity.schema),
            self._settings,
        )
        self.controller = CController(self)

    def view(self) -> View:
        """The state now; overwritten by the next call."""
        self._lib.cw_twin_view(self._memory, ctypes.byref(self._view))
        return self._view

    def receive_bytes(self, data: bytes, now_s: float) -> None:
        for at in range(0, len(data), 0xFFFF):
            part = data[at : at + 0xFFFF]
            now = ctypes.c_uint32(_us(now_s))
            self._lib.cw_twin_receive(self._memory, part, ctypes.c_uint16(len(part)), now)

    def next_frame(self, now_s: float) -> bytes:
        size = self._lib.cw_twin_next_frame(self._memory, self._out, ctypes.c_uint32(_us(now_s)))
        return self._out.raw[:size]

    def quiet_s(self) -> float:
        """0: it is asked in every turn."""
        return 0.0

    @property
    def session(self) -> int | None:
        view = self.view()
        return view.session_number if view.has_session else None

    @property
    def session_errors(self) -> int:
        return int(self.view().session_errors)


class CController:
    """What the loops and scenarios use of ``RobotController``."""

    def __init__(self, robot: CRobot) -> None:
        self._robot = robot

    def __getattr__(self, name: str) -> int:
        return int(getattr(self._robot.view(), name))

    @property
    def state(self) -> RobotState:
        return RobotState(self._robot.view().state)

    @property
    def reason(self) -> StopReason:
        return StopReason(self._robot.view().reason)

    @property
    def wheels(self) -> WheelSpeeds:
        view = self._robot.view()
        return WheelSpeeds(
            view.left / EIGHTHS_PER_M, view.right / EIGHTHS_PER_M, bool(view.powered)
        )

    def tick(self, now_s: float) -> None:
        self._robot._lib.cw_twin_tick(self._robot._memory, ctypes.c_uint32(_us(now_s)))

    def step(self, now_s: float, left_m: float, right_m: float) -> WheelSpeeds:
        self._robot._lib.cw_twin_step(
            self._robot._memory,
            ctypes.c_uint32(_us(now_s)),
            ctypes.c_uint32(round(left_m * 1e6) & 0xFFFFFFFF),
            ctypes.c_uint32(round(right_m * 1e6) & 0xFFFFFFFF),
        )
        return self.wheels

    def emergency_stop(self, reason: StopReason = StopReason.ESTOP_HOST) -> None:
        self._robot._lib.cw_twin_estop(self._robot._memory, ctypes.c_uint8(reason))


__all__ = ["SCHEMA_HASH", "CRobot", "library", "missing_tool"]
