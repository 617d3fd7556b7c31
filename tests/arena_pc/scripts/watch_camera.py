"""Reads a camera as a run does, and prints a line where its state or its reason changes.

    watch_camera.py DEVICE RATE_HZ

A line is ``STATE CAPTURED REASON``; there is one for every fifty pictures, too. What a camera that
runs says of its rate is left out: an emulated machine stumbles.
"""

import sys
import time

from vision.camera.camera import Camera
from vision.camera.latest_frame import LatestFrame
from vision.camera.sources import DeviceSettings, KnownCamera, camera_for

LOOK_S = 0.2


def main(device: str, rate_hz: float) -> None:
    """Watch until killed."""
    known = KnownCamera()
    settings = DeviceSettings(colour=False)

    def open_camera() -> Camera:
        return camera_for(
            device,
            clock=time.monotonic,
            rate_hz=rate_hz,
            size=(640, 480),
            device=settings,
            known=known,
        )

    shown, counted = "", 0
    with LatestFrame(open_camera, time.monotonic) as reader:
        while True:
            reader.take(LOOK_S)
            status = reader.status()
            news = status.state if status.state == "running" else f"{status.state} {status.reason}"
            if news != shown or status.captured >= counted + 50:
                shown, counted = news, status.captured
                print(status.state, status.captured, status.reason)


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
