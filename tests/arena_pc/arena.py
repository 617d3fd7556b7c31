"""The configuration of the tests: a USB camera of 640x480 and a robot behind an FTDI adapter."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from tests.arena_pc.machine.usb_sockets import ADAPTER, CAMERA

CONFIGS = Path(__file__).parents[2] / "configs"
FILE = "/etc/clearway/arena.yaml"
CALIBRATION = "/etc/clearway/calibration.yaml"
TEXT = f"""
arena:
  bounds_m: [0.0, 0.0, 2.4, 1.8]
camera:
  source: {CAMERA.format("C1")}
  size_px: [640, 480]
  rate_hz: 10
  calibration: {CALIBRATION}
robot:
  marker_id: 7
  marker_size_m: 0.09
  marker_height_m: 0.12
  radius_m: 0.09
  speed_m_s: 0.12
serial:
  port: {ADAPTER.format("A1")}
safety:
  pose_stale_s: 0.5
  frame_stale_s: 0.5
mission:
  stations:
    - {{x_m: 0.72, y_m: 1.52}}
"""


def calibration() -> str:
    """That of the simulated camera for pictures of half its size."""
    known = yaml.safe_load((CONFIGS / "simulation_calibration.yaml").read_text())
    whole_from_half = np.array([[2.0, 0.0, 0.5], [0.0, 2.0, 0.5], [0.0, 0.0, 1.0]])
    lens = np.linalg.inv(whole_from_half) @ np.array(known["camera_matrix"])
    plane = np.array(known["arena_from_pixel"]) @ whole_from_half
    return yaml.safe_dump(
        {
            **known,
            "size": [640, 480],
            "camera_matrix": lens.tolist(),
            "arena_from_pixel": (plane / plane[2, 2]).tolist(),
        }
    )


def files() -> tuple[tuple[str, str], ...]:
    """The configuration and its calibration, by their names in the guest."""
    return (FILE, TEXT), (CALIBRATION, calibration())
