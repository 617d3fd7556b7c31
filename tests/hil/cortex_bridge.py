"""The Cortex-M binary on an emulated board, for a program that steps it. Test only.

    python tests/hil/cortex_bridge.py FIRMWARE.elf

Runs qemu-system-arm with the board MPS2 (AN385) and speaks on stdin and stdout as
``tests.support.robots.emulated_processor`` says. The emulated processor runs in real time,
whatever time is asked for: the asking program has to keep to it. Its first serial port is the
robot's line, with
115200 baud in both directions; behind the second one this program is the motor board, whose
frames ``port_cortex_m.c`` defines. The motor board takes the power away where it has heard no
order for a fifth of a second. Where the environment names a socket as CORTEX_DEBUGGER, a debugger
can connect there.
"""

from __future__ import annotations

import contextlib
import ctypes
import math
import os
import secrets
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections import deque
from pathlib import Path

CYCLES_US = 16
"""The protocol counts cycles of 16 MHz."""
BYTE_US = 1e7 / 115_200
FULL_SPEED = 0.8 * 8000.0
"""Eighths of mm/s at full PWM."""
SILENT_US = 200_000
REPORT_US = 5_000
SEED_AT = 0x2000F000
REQUEST = struct.Struct("<IhhBH")
ANSWER = struct.Struct("<BBBIIH")
ORDER, REPORT = 0xA5, 0x5A
FRAME = struct.Struct("<BhhBB")
ORDER_FRAME_SIZE = 7
PR_SET_PDEATHSIG = 1


def command_of(firmware: str, folder: Path) -> list[str]:
    """How to start the emulator; its three lines are sockets in a folder."""
    command = ["qemu-system-arm", "-M", "mps2-an385", "-display", "none", "-nodefaults"]
    for name, line in (("wire", "-serial"), ("board", "-serial"), ("monitor", "-monitor")):
        command += ["-chardev", f"socket,id={name},path={folder / name}", line, f"chardev:{name}"]
    seed = f"loader,addr={SEED_AT:#x},data={secrets.randbits(32):#x},data-len=4"
    if debugger := os.environ.get("CORTEX_DEBUGGER"):
        command += ["-gdb", f"unix:{debugger},server=on,wait=off"]
    return [*command, "-device", seed, "-kernel", firmware]


def end_with_parent() -> None:
    """Called in the emulator's process: it must not outlive a bridge that is killed."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


class Line:
    """One end of a serial line at its baud rate; ``now_us`` only grows."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._waiting: deque[int] = deque()
        self._next_us = 0.0

    def give(self, data: bytes) -> None:
        """Bytes to send; they wait for their turn."""
        self._waiting.extend(data)

    def send(self, now_us: float) -> None:
        """Send what has had its time by now; what the processor does not take is lost."""
        due = bytearray()
        while self._waiting and self._next_us <= now_us:
            due.append(self._waiting.popleft())
            self._next_us = max(self._next_us, now_us - 2_000.0) + BYTE_US
        with contextlib.suppress(BlockingIOError):  # lost, as where nobody listens
            self._connection.send(bytes(due), socket.MSG_DONTWAIT)

    def receive(self) -> bytes:
        """What has come in."""
        try:
            return self._connection.recv(4096, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return b""


class MotorBoard:
    """Orders in, encoder steps out.

    The processor's time is real time, the asking program's may be behind it for a moment. So
    orders are kept with the time of their coming, and obeyed when the asker's time has come to it:
    the wheels turn as long as they were told to, however busy the machine is.
    """

    def __init__(self) -> None:
        self.speeds = [0, 0]
        self.powered = False
        self.off_us = 0
        self._heard_us = 0
        self._reported_us = 0
        self._steps = [0, 0]
        self._rest = [0.0, 0.0]
        self._partial = bytearray()
        self._arrived: deque[tuple[float, bytes]] = deque()
        self._behind_s = math.inf

    def listen(self, connection: socket.socket) -> None:
        """Keep what comes, until the other end is closed; for a thread of its own."""
        with contextlib.suppress(OSError):
            while data := connection.recv(4096):
                self._arrived.append((time.monotonic(), data))

    def obey(self, now_us: int) -> None:
        """What had come by that time of the asker."""
        # an asker is never early: where it was least late, its time is that of the clock
        self._behind_s = min(self._behind_s, time.monotonic() - now_us * 1e-6)
        while self._arrived and self._arrived[0][0] <= self._behind_s + now_us * 1e-6:
            self._hear(self._arrived.popleft()[1], now_us)

    def _hear(self, data: bytes, now_us: int) -> None:
        """Bytes that are no order are passed over."""
        self._partial += data
        while len(self._partial) >= ORDER_FRAME_SIZE:
            frame = bytes(self._partial[:ORDER_FRAME_SIZE])
            if frame[0] != ORDER or sum(frame) % 256 != 0:
                del self._partial[0]
                continue
            del self._partial[:ORDER_FRAME_SIZE]
            left, right = struct.unpack_from("<hh", frame, 1)
            self._heard_us = now_us
            self._power(frame[5] == 1, now_us)
            self.speeds = [left, right]

    def _power(self, powered: bool, now_us: int) -> None:
        if self.powered and not powered:
            self.off_us = now_us
        self.powered = powered

    def turn(self, left: int, right: int, now_us: int) -> bytes:
        """The wheels have made so many steps: a report, where one is due."""
        if now_us - self._heard_us > SILENT_US:
            self._power(False, now_us)
        self._steps = [self._steps[0] + left, self._steps[1] + right]
        if now_us - self._reported_us < REPORT_US:
            return b""
        self._reported_us = now_us
        counts = [(count + 0x8000) % 0x10000 - 0x8000 for count in self._steps]
        body = struct.pack("<BBhh", REPORT, 0, *counts)
        return body + bytes([-sum(body) % 256])

    def pwm(self) -> tuple[int, int, int]:
        """PWM left and right, and the flags. What a step of it is too coarse for is carried on."""
        duties = []
        for side, speed in enumerate(self.speeds):
            fine = min(abs(speed) / FULL_SPEED * 255.0 + self._rest[side], 255.0)
            duties.append(int(fine))
            self._rest[side] = fine - duties[-1]
        left, right = duties
        flags = int(self.powered) | (self.speeds[0] < 0) << 1 | (self.speeds[1] < 0) << 2
        return left, right, flags


def serve(ends: dict[str, socket.socket], qemu: subprocess.Popen[bytes]) -> None:
    """Answer requests until stdin ends."""
    wire, board_line = Line(ends["wire"]), Line(ends["board"])
    board, now_us = MotorBoard(), 0
    threading.Thread(target=board.listen, args=(ends["board"],), daemon=True).start()
    said = bytearray()
    while len(head := sys.stdin.buffer.read(REQUEST.size)) == REQUEST.size:
        us, left, right, flags, count = REQUEST.unpack(head)
        wire.give(sys.stdin.buffer.read(count))
        if flags & 1:
            ends["monitor"].sendall(b"system_reset\n")
        now_us += us
        board_line.give(board.turn(left, right, now_us))
        for line in (wire, board_line):
            line.send(now_us)
        if qemu.poll() is not None:
            return
        said += wire.receive()
        board.obey(now_us)
        due = bytes(said[: max(1, int(us / BYTE_US)) if us else 0])
        del said[: len(due)]
        off, now = (value * CYCLES_US % (1 << 32) for value in (board.off_us, now_us))
        sys.stdout.buffer.write(ANSWER.pack(*board.pwm(), off, now, len(due)) + due)
        sys.stdout.buffer.flush()


def main(firmware: str) -> int:
    """Start the emulator and serve; the exit code."""
    command: list[str] = []
    qemu = None
    try:
        # whoever wanted this program kills it: the folder is not needed once all are connected
        with tempfile.TemporaryDirectory(prefix="clearway_cortex_") as name:
            folder = Path(name)
            listeners = {}
            for line in ("wire", "board", "monitor"):
                listeners[line] = socket.socket(socket.AF_UNIX)
                listeners[line].bind(str(folder / line))
                listeners[line].listen(1)
                listeners[line].settimeout(10.0)
            command = command_of(firmware, folder)
            qemu = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=sys.stderr, preexec_fn=end_with_parent
            )
            ends = {line: listener.accept()[0] for line, listener in listeners.items()}
        serve(ends, qemu)
    except (TimeoutError, BrokenPipeError, ConnectionError):
        print(f"cortex_bridge: the emulator did not start: {command[0]}", file=sys.stderr)
        return 1
    finally:
        if qemu is not None:
            qemu.kill()
            qemu.wait()
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        print("cortex_bridge: needs the firmware's file", file=sys.stderr)
        os._exit(2)
    sys.exit(main(sys.argv[1]))
