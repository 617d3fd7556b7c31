"""What is no argument of vision's public functions is refused where it comes in, by its name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vision
from tests.support.wrong_values import refuses

PICTURE = np.full((48, 64), 220, np.uint8)
PICTURE[10:30, 10:30] = 20
PLAN = vision.Calibration.from_scale(0.005, (64, 48))


def extract(**changes: Any) -> Any:
    return vision.extract(PICTURE, **changes)


TABLE: list[tuple[str, Callable[[Any], Any], str]] = [
    ("picture", vision.extract, ""),
    ("mode", lambda it: extract(mode=it), ""),
    ("polarity", lambda it: extract(polarity=it), ""),
    ("method", lambda it: extract(method=it), ""),
    ("threshold", lambda it: extract(threshold=it), "None, a number"),
    ("calibration", lambda it: extract(calibration=it), "None"),
    ("bounds", lambda it: extract(calibration=PLAN, bounds=it), "None"),
    ("ignore", lambda it: extract(ignore=it), "None, numbers, nothing, an array"),
    ("scene", vision.doubts_about, ""),
    ("metres_per_pixel", lambda it: vision.Calibration.from_scale(it, (64, 48)), "a number"),
    ("size", lambda it: vision.Calibration.from_scale(0.005, it), ""),
    ("points", PLAN.arena_from_image, "nothing, a cube, rows of nan"),
]


@pytest.mark.parametrize(("named", "call", "fine"), TABLE)
def test_what_is_no_argument_is_refused_by_its_name(
    named: str, call: Callable[[Any], Any], fine: str
) -> None:
    refuses(call, named, fine)


def test_only_a_calibration_is_saved(tmp_path: Path) -> None:
    refuses(lambda it: vision.save_calibration(it, tmp_path / "c.yaml"), "calibration", "")
    assert not (tmp_path / "c.yaml").exists()
