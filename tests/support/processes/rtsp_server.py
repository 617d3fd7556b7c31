"""A network camera by GStreamer's RTSP server, with faults on demand.

    python3 rtsp_server.py PORT h264|jpeg RATE

runs in the Python that Debian's python3-gi and gir1.2-gst-rtsp-server-1.0 belong to, and needs
nothing else. It serves rtsp://127.0.0.1:PORT/test, grey pictures of 320x240 that get lighter by
5 each, and prints a line when it is ready. A line on its input sets what it does: ``live``,
``stalled`` (connected, but nothing comes) or ``frozen`` (the same picture again and again).
"""

from __future__ import annotations

import sys
import threading
import time

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstRtspServer", "1.0")
from gi.repository import GLib, Gst, GstRtspServer  # noqa: E402

WIDTH, HEIGHT = 320, 240
CODECS = {
    "h264": "x264enc tune=zerolatency key-int-max=25 ! rtph264pay name=pay0 pt=96",
    "jpeg": "jpegenc ! rtpjpegpay name=pay0 pt=26",
}


def main(port: str, codec: str, rate_hz: int) -> None:
    Gst.init(None)
    mode = ["live"]

    def feed(source) -> None:
        number = 0
        while True:
            # the wait is the camera's frame rate
            time.sleep(1.0 / rate_hz)
            if mode[0] == "stalled":
                continue
            number += mode[0] == "live"
            data = bytes([40 + 5 * (number % 40)]) * (WIDTH * HEIGHT)
            if source.emit("push-buffer", Gst.Buffer.new_wrapped(data)) != Gst.FlowReturn.OK:
                return

    class Factory(GstRtspServer.RTSPMediaFactory):
        def do_create_element(self, _url):
            return Gst.parse_launch(
                "appsrc name=source is-live=true format=time do-timestamp=true "
                f"caps=video/x-raw,format=GRAY8,width={WIDTH},height={HEIGHT},"
                f"framerate={rate_hz}/1 ! videoconvert ! video/x-raw,format=I420 ! {CODECS[codec]}"
            )

        def do_configure(self, media):
            source = media.get_element().get_by_name_recurse_up("source")
            threading.Thread(target=feed, args=(source,), daemon=True).start()

    def listen() -> None:
        for line in sys.stdin:
            mode[0] = line.strip()

    server = GstRtspServer.RTSPServer()
    server.set_address("127.0.0.1")
    server.set_service(port)
    factory = Factory()
    factory.set_shared(True)
    server.get_mount_points().add_factory("/test", factory)
    server.attach(None)
    threading.Thread(target=listen, daemon=True).start()
    print("ready", flush=True)
    GLib.MainLoop().run()


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
