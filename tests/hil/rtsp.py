"""The stream camera on a real RTSP server: stalled, frozen, killed and started again.

    make rtsp

takes two minutes and ends with 1 where a stream was not taken up again, or a state not seen.
"""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from vision.camera.latest_frame import CameraStatus, LatestFrame
from vision.camera.sources import camera_for

SERVER = Path(__file__).parents[1] / "support" / "processes" / "rtsp_server.py"
RATE_HZ = 25
MOST_S = 40.0
"""How long anything may take: FFmpeg waits five seconds for a stream that says nothing."""


class Server:
    """The server's process, by Debian's own Python."""

    def __init__(self, port: int, codec: str) -> None:
        command = ["/usr/bin/python3", str(SERVER), str(port), codec, str(RATE_HZ)]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert self._process.stdout is not None
        if self._process.stdout.readline() != "ready\n":
            raise SystemExit("the RTSP server does not start: make rtsp installs what it needs")

    def tell(self, mode: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(mode + "\n")
        self._process.stdin.flush()

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()


@contextmanager
def serving(port: int, codec: str) -> Iterator[Server]:
    server = Server(port, codec)
    try:
        yield server
    finally:
        server.kill()


class Witness:
    """Waits for a camera's states and prints how long each took."""

    def __init__(self, reader: LatestFrame) -> None:
        self._reader = reader
        self.failed = 0

    def see(self, what: str, state: str, reason: str = "") -> CameraStatus:
        begin_s = time.monotonic()
        while True:
            self._reader.take(0.05)
            status = self._reader.status()
            fresh = state != "running" or (status.age_s is not None and status.age_s < 0.5)
            if status.state == state and reason in status.reason and fresh:
                break
            if time.monotonic() - begin_s > MOST_S:
                self.failed += 1
                print(f"FAILED: {what}: still {status}", flush=True)
                return status
        print(
            f"{what}: {state} after {time.monotonic() - begin_s:.1f} s {status.reason}", flush=True
        )
        return status

    def check(self, what: str, well: bool) -> None:
        self.failed += not well
        print(f"{'well' if well else 'FAILED'}: {what}", flush=True)


def watch(codec: str) -> int:
    """One server through all its faults; how much went wrong."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    url = f"rtsp://user:secret@127.0.0.1:{port}/test"
    reader = LatestFrame(lambda: camera_for(url, clock=time.monotonic), time.monotonic)
    witness = Witness(reader)
    with reader:
        with serving(port, codec) as server:
            witness.see(f"{codec}, opened", "running")
            end_s = time.monotonic() + 4.0
            while time.monotonic() < end_s:
                reader.take(0.1)
            rate_hz = reader.status().rate_hz
            witness.check(f"{rate_hz:.1f} frames/s of {RATE_HZ}", 15.0 < rate_hz < 30.0)
            server.tell("stalled")
            witness.see("stalled", "stalled", "no picture for")
            server.tell("live")
            witness.see("live again", "running")
            server.tell("frozen")
            witness.see("frozen", "frozen", "the camera is frozen")
            server.tell("live")
            witness.see("live again", "running")
        for pause in ("0.25", "0.5", "1"):
            witness.see("killed", "lost", f"trying again in {pause} s")
        said = reader.status().reason
        witness.check("no password is shown", "secret" not in said)
        with serving(port, codec):
            witness.see("started again", "running")
    return witness.failed


def main() -> int:
    return 1 if sum(watch(codec) for codec in ("h264", "jpeg")) else 0


if __name__ == "__main__":
    sys.exit(main())
