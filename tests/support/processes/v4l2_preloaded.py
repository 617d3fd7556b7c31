"""Programs that run with cameras of the library ``v4l2_camera.c``, which is preloaded."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np
import pytest

ROOT = Path(__file__).parents[3]
SOURCE = ROOT / "tests" / "support" / "processes" / "v4l2_camera.c"
NEEDS_GCC = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")


@cache
def built() -> tuple[TemporaryDirectory[str], Path]:
    """The library, built once a process; its folder goes with the process."""
    folder = TemporaryDirectory(prefix="clearway-v4l2-")
    made = Path(folder.name) / "v4l2_camera.so"
    flags = ["-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    subprocess.run(["gcc", *flags, "-o", made, SOURCE, "-ldl"], check=True, timeout=60)
    return folder, made


def environment(cameras: list[Path], **more: str) -> dict[str, str]:
    """The environment of a program that sees these cameras; ``more`` as the library says."""
    listed = ":".join(map(str, cameras))
    return {**os.environ, "LD_PRELOAD": str(built()[1]), "V4L2_CAMERA": listed, **more}


def run(script: str, cameras: list[Path], *arguments: object, **more: str) -> Any:
    """What a script prints, in JSON."""
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)],
        env=environment(cameras, **more), cwd=ROOT, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def jpegs(folder: Path, size: tuple[int, int], count: int = 3) -> str:
    """Files of noisy pictures, as ``V4L2_JPEGS`` lists them; their mean grey is 60, 90, ..."""
    width, height = size
    names = []
    for number in range(count):
        rng = np.random.default_rng(number)
        grey = np.clip(rng.normal(60 + 30 * number, 4.0, (height, width, 1)), 0, 255)
        picture = np.repeat(grey, 3, axis=2).astype(np.uint8)
        names.append(folder / f"picture{number}.jpg")
        cv2.imwrite(str(names[-1]), picture, [cv2.IMWRITE_JPEG_QUALITY, 80])
    return ":".join(map(str, names))


def video_nodes(folder: Path, *names: str) -> Iterator[Path]:
    """Files in the place of device nodes."""
    for name in names:
        (folder / name).touch()
        yield folder / name
