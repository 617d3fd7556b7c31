"""From a SOURCE on the command line to a scene: a picture, a scene, a ROS or MovingAI map.

A picture, judged by its content or its name, is for ``vision.extract``; anything else is read by
``planner.load_scene``. The pictures of ROS maps that are not PGM (map_saver can write PNG) are
decoded here too, since the planner knows no OpenCV.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from navigation.cli.cold_kernels import compile_what_is_missing
from navigation.cli.options import STANDARD_STREAM, Binarising
from navigation.cli.outputs import named
from planner.formats.map_files import MOST_BYTES, Shades, read_bytes
from planner.formats.scene_io import is_picture, scene_from_bytes
from planner.scene import Bounds, Scene, SceneError
from planner.zones.zone import Zone

AS_USUAL = Binarising()
PICTURE_SUFFIXES = frozenset(
    (
        *(".png", ".jpg", ".jpeg", ".bmp", ".gif", ".tif", ".tiff"),
        *(".webp", ".avif", ".jp2"),
        *(".pbm", ".pgm", ".ppm", ".pnm", ".pam", ".ras"),
    )
)


def compile_for(source: Path) -> None:
    """Compile any missing kernels for planning on a SOURCE: the eye only for pictures."""
    if source == STANDARD_STREAM:
        begin = read_source(source)[:64]
    else:
        with source.open("rb") as stream:
            begin = stream.read(64)
    picture = is_picture(begin) or source.suffix.lower() in PICTURE_SUFFIXES
    compile_what_is_missing(*(("eye", "planner") if picture else ("planner",)))


def zones_in(file: Path | None) -> tuple[Zone, ...]:
    """Zones of a file, none without one; ``ZoneError`` with every problem."""
    if file is None:
        return ()
    from navigation.config.zone_file import read_zones

    return read_zones(file)


def read_source(path: Path) -> bytes:
    """Bytes of a file, or of standard input; `SceneError` if it cannot be read."""
    return _standard_input() if path == STANDARD_STREAM else read_bytes(path)


@cache
def _standard_input() -> bytes:
    """All of standard input, which can be read once."""
    if sys.stdin is None:
        raise SceneError("standard input: is closed")
    data = sys.stdin.buffer.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise SceneError(f"standard input: more than {MOST_BYTES} bytes: must be at most that")
    return data


def load_source(
    path: Path,
    binarising: Binarising = AS_USUAL,
    least_area: float | None = None,
    clock: Callable[[], float] = time.perf_counter,
) -> Scene:
    """Scene of any SOURCE; ``timings_ms`` gains ``load``: reading and decoding.

    ``least_area`` leaves out smaller obstacles. `SceneError`, or a ValueError of ``vision``, naming
    the file; also if a method is given to binarise something that is not a picture.
    """
    begin_s = clock()
    data, file = read_source(path), named(path)
    if is_picture(data) or path.suffix.lower() in PICTURE_SUFFIXES:
        image, remarks = decode_picture(data, file)
        loaded_s = clock()
        scene = _extract(image, binarising, file)
        scene = replace(scene, remarks=(*remarks, *scene.remarks))
    elif binarising.method != "auto":
        raise SceneError(f"{file}: no picture: --method {binarising.method} is for pictures only")
    else:
        scene = scene_from_bytes(data, file, read_picture=read_shades)
        loaded_s = clock()
    if least_area is not None:
        scene = scene.without_specks(least_area)
    return replace(scene, timings_ms={"load": 1e3 * (loaded_s - begin_s), **scene.timings_ms})


def read_shades(path: Path) -> Shades:
    """A map's picture as shades in [0, 1] and a mask of its transparent pixels.

    The cells are those of the file: map servers ignore its EXIF orientation.
    """
    from navigation.shared.map_pictures import shades_of

    image, doubts = _decode(read_bytes(path), path)
    if doubts:
        raise SceneError(f"{path}: {doubts[0]}")
    return shades_of(image)


def hold_points(scene: Scene, points: list[tuple[float, float]], room: float) -> Scene:
    """Grow the scene's derived bounds to hold the points with ``room`` around them.

    Bounds given by the source are the arena's walls and stay.
    """
    b = scene.bounds
    if scene.bounds_given or all(b.contains(p) for p in points):
        return scene
    xs, ys = zip(*points, strict=True)
    bounds = Bounds(
        min(b.x_min, min(xs) - room),
        min(b.y_min, min(ys) - room),
        max(b.x_max, max(xs) + room),
        max(b.y_max, max(ys) + room),
    )
    return replace(scene, bounds=bounds)


def decode_picture(data: bytes, path: Path) -> tuple[NDArray[Any], tuple[str, ...]]:
    """A picture, turned by its EXIF orientation, and remarks: grey, BGR or BGRA, 8 or 16 bits.

    `SceneError`, naming the file, if ``data`` is not a picture or is damaged.
    """
    from vision.camera.picture_turn import orientation, turned

    image, remarks = _decode(data, path)
    exif = orientation(data)
    if exif == 1:
        return image, remarks
    return turned(image, exif), (*remarks, f"turned by its EXIF orientation, {exif}")


def _decode(data: bytes, path: Path) -> tuple[NDArray[Any], tuple[str, ...]]:
    """A file's picture as stored, and remarks."""
    import cv2

    from navigation.cli.decoder_lines import caught_decoder_lines
    from vision.camera.picture_size import oversize

    if not data:
        raise SceneError(f"{path}: the file is empty: must hold a picture")
    large = oversize(data)
    if large:
        raise SceneError(f"{path}: {large}")
    with caught_decoder_lines() as said:
        try:
            image = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
        except cv2.error:
            image = None
    if image is None and not is_picture(data):
        raise SceneError(f"{path}: not a picture: its content is none that OpenCV can decode")
    if image is None:
        why = f" ({said.damage})" if said.damage else ""
        raise SceneError(f"{path}: a damaged picture, or of a kind that OpenCV cannot decode{why}")
    if said.damage:
        raise SceneError(f"{path}: a damaged picture: {said.damage}")
    if image.dtype not in (np.uint8, np.uint16):
        raise SceneError(f"{path}: a picture of {image.dtype}: must have 8 or 16 bits a channel")
    return image, ((f"the picture may be damaged: {said.doubt}",) if said.doubt else ())


def _extract(image: NDArray[Any], binarising: Binarising, path: Path) -> Scene:
    import vision

    try:
        return vision.extract(image, **binarising._asdict())
    except ValueError as error:
        raise SceneError(f"{path}: {error}") from error
