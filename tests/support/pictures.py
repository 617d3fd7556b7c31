"""Pictures that the system tests look at, and the `clearway` entry point called in-process.

Pixel centres lie at integers: a filled rectangle from (200, 150) to (300, 300), both included,
covers [199.5, 300.5] x [149.5, 300.5].
"""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from navigation.cli.main import run

FREE, SOLID = 235, 25


class Told(NamedTuple):
    """What a call of the command line came to."""

    code: int
    out: str
    err: str


def call(*arguments: object) -> Told:
    """Run ``clearway ARGUMENTS`` in this process."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = run([str(a) for a in arguments])
    return Told(code, out.getvalue(), err.getvalue())


def blank(width: int = 640, height: int = 480, level: int = FREE) -> NDArray[np.uint8]:
    """An even picture."""
    return np.full((height, width), level, np.uint8)


def box_and_disc() -> NDArray[np.uint8]:
    """640 x 480: a rectangle on the left of the middle, a disc on its right."""
    picture = blank()
    cv2.rectangle(picture, (200, 150), (300, 300), SOLID, -1)
    cv2.circle(picture, (450, 240), 60, SOLID, -1)
    return picture


def gate(gap: int = 40) -> NDArray[np.uint8]:
    """640 x 480: a wall from top to bottom at x = 300 .. 340 with a gap of ``gap`` rows.

    The gap's rows are 220 .. 220 + gap - 1, so its free width is ``gap`` pixels.
    """
    picture = blank()
    picture[:220, 300:341] = SOLID
    picture[220 + gap :, 300:341] = SOLID
    return picture


def save(folder: Path, name: str, picture: NDArray[Any]) -> Path:
    """Write a picture losslessly and give its path."""
    file = folder / name
    assert cv2.imwrite(str(file), picture)
    return file
