"""A camera on the network: Motion JPEG over HTTP, with faults on demand."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import cv2
import numpy as np

RATE_HZ = 25.0


class MjpegServer:
    """Serves pictures of 64x48 whose grey value tells their number, one more each.

    ``mode``: ``live``, ``stalled`` (connected, but nothing comes), ``frozen`` (the same picture
    again and again) or ``lost`` (connections are closed at once).
    """

    def __init__(self) -> None:
        self.mode = "live"
        self.connections = 0
        self.sent = 0
        self._over = threading.Event()
        owner = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                owner._serve(self)

            def log_message(self, *_: object) -> None:
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self.url = f"http://127.0.0.1:{self._server.server_address[1]}/stream.mjpg"
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.05,))
        self._thread.start()

    def close(self) -> None:
        self._over.set()
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()

    def _serve(self, handler: BaseHTTPRequestHandler) -> None:
        self.connections += 1
        if self.mode == "lost":
            handler.send_error(503)
            return
        handler.send_response(200)
        handler.send_header("Content-Type", "multipart/x-mixed-replace; boundary=next")
        handler.end_headers()
        try:
            # The wait is the camera's frame rate.
            while not self._over.wait(1.0 / RATE_HZ) and self.mode != "lost":
                if self.mode == "stalled":
                    continue
                if self.mode == "live":
                    self.sent += 1
                data = picture(self.sent)
                head = f"--next\r\nContent-Type: image/jpeg\r\nContent-Length: {len(data)}\r\n\r\n"
                handler.wfile.write(head.encode() + data + b"\r\n")
        except OSError:
            pass  # the reader has gone


def picture(number: int) -> bytes:
    """A JPEG of 64x48, grey 40, 45, 50, ... by its number."""
    grey = np.full((48, 64, 3), 40 + 5 * (number % 40), np.uint8)
    grey[10:30, 10:20] = 255 - grey[10:30, 10:20]
    return bytes(cv2.imencode(".jpg", grey)[1].tobytes())


@contextmanager
def mjpeg_server() -> Iterator[MjpegServer]:
    server = MjpegServer()
    try:
        yield server
    finally:
        server.close()
