"""A network camera above the simulated arena: Motion JPEG over HTTP, with faults on order.

    python -m benchmarks.adversary.stage.camera_server RUN.yaml [--port N] [--seed N]

Each picture shows the robot where its pose file has it at the moment of the exposure. The first
line on standard output is the address; faults come on standard input, a JSON object each, whose
keys are those of `Faults`; what a line does not name goes back to normal. Loopback only.
"""

from __future__ import annotations

import argparse
import json
import sys
import threading
import time
from collections import deque
from collections.abc import Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from benchmarks.adversary.scene import read_config
from benchmarks.adversary.stage.film import Faults, Film
from navigation.simulator.shared_pose import PoseFileError, PoseReader

KEPT_S = 4.0
"""Pictures of the past, for a recording that is shown again and again."""
QUALITY = 90
MOST_VIEWERS = 8


class Stream:
    """Makes pictures in a thread; each visitor gets the newest that is due."""

    def __init__(self, film: Film, poses: PoseReader, rate_hz: float) -> None:
        self.film, self._poses = film, poses
        self._period_s = 1.0 / rate_hz
        self._news = threading.Condition()
        self._data, self._number = b"", 0
        self._made: deque[tuple[float, bytes]] = deque()
        """When each picture was taken, and its JPEG, oldest first."""
        self._loop: list[tuple[float, bytes]] = []
        self._faults, self._since_s = Faults(), 0.0
        self.over = threading.Event()

    def set_faults(self, faults: Faults) -> None:
        self._faults, self._since_s = faults, time.monotonic()

    def produce(self) -> None:
        due_s = time.monotonic()
        while not self.over.is_set():
            due_s = max(due_s + self._period_s, time.monotonic() - self._period_s)
            self.over.wait(max(0.0, due_s - time.monotonic()))
            now_s = time.monotonic()
            try:
                pose = self._poses.read()
            except PoseFileError:
                continue  # the robot is being started
            faults = self._faults
            picture = self.film.picture(pose, faults, now_s - self._since_s)
            data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()
            self._made.append((now_s, data))
            while self._made[0][0] < now_s - KEPT_S:
                self._made.popleft()
            self._publish(self._due(faults, now_s), faults)

    def _due(self, faults: Faults, now_s: float) -> bytes:
        """What leaves the camera now: the past, where it is late or shows a recording."""
        made: Sequence[tuple[float, bytes]] = self._made
        shown_s = now_s - faults.latency_s
        if faults.loop_s > 0.0:
            began_s = self._since_s - faults.loop_s
            if not self._loop:
                self._loop = [one for one in self._made if began_s <= one[0] <= self._since_s]
            shown_s = began_s + (now_s - self._since_s) % faults.loop_s
            made = self._loop
        past = [data for made_s, data in made if made_s <= shown_s]
        return past[-1] if past else made[0][1]

    def _publish(self, data: bytes, faults: Faults) -> None:
        if faults.stalled:
            return
        if faults.truncated:
            data = data[: len(data) * 6 // 10]
        with self._news:
            self._data, self._number = data, self._number + 1
            self._news.notify_all()

    def serve(self, handler: BaseHTTPRequestHandler) -> None:
        if self._faults.dead:
            handler.send_error(503)
            return
        handler.send_response(200)
        handler.send_header("Content-Type", "multipart/x-mixed-replace; boundary=next")
        handler.end_headers()
        seen = 0
        try:
            while not self.over.is_set() and not self._faults.dead:
                with self._news:
                    if self._number == seen:
                        self._news.wait(0.2)
                    data, number = self._data, self._number
                if number == seen:
                    continue
                seen = number
                head = f"--next\r\nContent-Type: image/jpeg\r\nContent-Length: {len(data)}\r\n\r\n"
                handler.wfile.write(head.encode() + data + b"\r\n")
        except OSError:
            pass  # the reader has gone


def make_server(stream: Stream, port: int) -> ThreadingHTTPServer:
    """At a loopback port; 0: any."""
    places = threading.BoundedSemaphore(MOST_VIEWERS)

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            with places:
                stream.serve(self)

        def log_message(self, *_: object) -> None:
            pass

    class Server(ThreadingHTTPServer):
        daemon_threads = True
        allow_reuse_address = True

    return Server(("127.0.0.1", port), Handler)


def read_faults(line: str) -> Faults:
    """The faults of a line; unknown keys are a mistake of the judge's."""
    said: dict[str, Any] = json.loads(line)
    found: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in said.items()}
    return Faults(**found)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("config", type=Path)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    cv2.setNumThreads(1)
    config = read_config(options.config)
    assert config.simulation is not None
    assert config.simulation.robot.poses is not None
    film = Film(config, np.random.default_rng(options.seed))
    stream = Stream(film, PoseReader(config.simulation.robot.poses), config.camera.rate_hz)
    server = make_server(stream, options.port)
    for target in (stream.produce, lambda: server.serve_forever(0.05)):
        threading.Thread(target=target, daemon=True).start()
    print(f"http://127.0.0.1:{server.server_address[1]}/stream.mjpg", flush=True)
    for line in sys.stdin:
        stream.set_faults(read_faults(line))
    stream.over.set()
    server.shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
