"""Shipped configurations whose simulated camera costs a busy machine a quarter of the time.

For runs in real time in which the size of the pictures is not the subject.
"""

from __future__ import annotations

import re
from typing import Final

LENS: Final = "    focal_px: 617.5\n    centre_offset_px: [2.6, -1.9]\n"
"""Half of that of 1280 by 960 pixels: the same picture of the same floor."""


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
