"""Shipped configurations whose simulated camera costs a busy machine a quarter of the time.

For runs in real time in which the size of the pictures is not the subject.
"""

from __future__ import annotations

import re
from typing import Final

from navigation.config import Config

FOCAL_PX: Final = 617.5
OFFSET_PX: Final = (2.6, -1.9)
LENS: Final = f"    focal_px: {FOCAL_PX}\n    centre_offset_px: {list(OFFSET_PX)}\n"
"""Half of that of 1280 by 960 pixels: the same picture of the same floor."""


def in_small_pictures(config: Config) -> Config:
    """A configuration with pictures of 640 by 480 pixels in place of 1280 by 960."""
    assert config.camera.size_px == (1280, 960)
    assert config.simulation is not None
    # a calibration is of one size; without one the simulated lens is known
    camera = config.camera.model_copy(update={"size_px": (640, 480), "calibration": None})
    lens = {"focal_px": FOCAL_PX, "centre_offset_px": OFFSET_PX}
    simulated = config.simulation.camera.model_copy(update=lens)
    simulation = config.simulation.model_copy(update={"camera": simulated})
    return config.model_copy(update={"camera": camera, "simulation": simulation})


def with_light_camera(configuration: str) -> str:
    """The text of a configuration with pictures of 640 by 480 pixels, 20 a second."""
    for old, new in (
        (r"size_px: \[1280, 960\]", "size_px: [640, 480]"),
        (r"(?m)^  rate_hz: 30$", "  rate_hz: 20"),
        (r"(?m)^    (focal_px|centre_offset_px): .*\n", ""),
        (r"(?m)^(    position_m: .*\n)", rf"\1{LENS}"),
    ):
        configuration, count = re.subn(old, new, configuration)
        assert count == 1 or new == "", old
    # a calibration is of one size; without one the simulated lens is known
    return re.sub(r"(?m)^  calibration: simulation_calibration.yaml$", "", configuration)
