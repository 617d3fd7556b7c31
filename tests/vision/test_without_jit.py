"""Binarisation and border following are their own reference: as plain Python they answer alike."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

DIGEST = """
import hashlib, warnings
import numpy as np
# indices that count backwards wrap around on purpose
warnings.filterwarnings("ignore", "overflow encountered in scalar add", RuntimeWarning)
from vision.binarise.binarise import binarise
from vision.borders.contours import follow_borders
whole = hashlib.sha256()
rng = np.random.default_rng(5)
for sigma in (0.0, 6.0, 20.0):
    picture = np.full((40, 52), 200.0)
    picture[8:30, 10:35] = 40.0
    picture += rng.normal(0.0, sigma, picture.shape)
    binary = binarise(np.clip(picture, 0, 255).astype(np.uint8))
    whole.update(binary.mask.tobytes() + f"{binary.level:.9g} {binary.noise:.9g}".encode())
for share in (0.1, 0.5, 0.9):
    noise = (rng.random((23, 31)) > share).astype(np.uint8) * 255
    borders = follow_borders(binarise(noise, threshold=128).mask)
    for a in (borders.x, borders.y, borders.direction, borders.starts, borders.area):
        whole.update(np.ascontiguousarray(a, dtype=np.int64).tobytes())
print(len(borders.starts), whole.hexdigest())
"""


def test_mask_and_borders_are_the_same_without_the_compiler() -> None:
    answers = []
    for off in ("0", "1"):
        root = Path(__file__).parents[2]
        environment = {**os.environ, "NUMBA_DISABLE_JIT": off, "PYTHONPATH": str(root)}
        done = subprocess.run(
            [sys.executable, "-c", DIGEST],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
            timeout=120,
        )
        answers.append(done.stdout)
    assert answers[0] == answers[1]
    assert int(answers[0].split()[0]) > 3
