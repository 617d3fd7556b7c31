"""The camera of a live calibration: a configuration's, or any source.

SOURCE is a configuration, whose camera is used with its settings, or anything that `camera.source`
may be. A simulated configuration's camera sees a board that moves as asked.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from navigation.config import load_config
from navigation.config.values import SIMULATED
from navigation.run.devices.device_settings import device_settings
from navigation.simulator.picture.held_board import HeldBoardCamera
from vision.calibrate.board import BoardSpec
from vision.calibrate.live.session import LiveSession
from vision.camera.camera import Camera, Clock
from vision.camera.sources import camera_for


def live_camera(
    source: str, spec: BoardSpec, session: LiveSession, clock: Clock, wait: Callable[[float], None]
) -> Camera:
    """The camera of a source, closed; raises ``CameraError`` if there is none."""
    if Path(source).suffix.lower() not in (".yaml", ".yml"):
        return camera_for(source, clock=clock)
    config = load_config(source)
    wanted = config.camera
    if wanted.source != SIMULATED:
        return camera_for(
            wanted.source, clock=clock, rate_hz=wanted.rate_hz, size=wanted.size_px,
            device=device_settings(wanted),
        )  # fmt: skip
    seed = 0 if config.simulation is None else config.simulation.seed
    return HeldBoardCamera(config, spec, clock, wait, seed, session.wanted_pose)
