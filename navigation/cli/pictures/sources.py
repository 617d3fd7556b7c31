"""From a SOURCE on the command line to a scene: a picture, a scene text, a ROS or MovingAI map.

A file is judged by its content: what begins like a picture goes to ``vision.extract``, anything
else to ``planner.load_scene``. This is also where the pictures of ROS maps that are not PGM
(map_saver can write PNG) are decoded, since the planner knows no OpenCV.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from navigation.cli.cold_kernels import compile_what_is_missing
from planner.formats.map_files import Shades, read_bytes
from planner.formats.scene_io import is_picture, load_scene
from planner.scene import Bounds, Scene, SceneError

Polarity = Literal["dark", "light", "auto"]

PICTURE_SUFFIXES = frozenset(
    (
        *(".png", ".jpg", ".jpeg", ".bmp", ".gif", ".tif", ".tiff"),
        *(".webp", ".avif", ".jp2"),
        *(".pbm", ".pgm", ".ppm", ".pnm", ".pam", ".ras"),
    )
)


def compile_for(source: Path) -> None:
    """Compile, where it is missing, what planning on a SOURCE needs: the eye only for pictures."""
    with source.open("rb") as stream:
        picture = is_picture(stream.read(64)) or source.suffix.lower() in PICTURE_SUFFIXES
    compile_what_is_missing(*(("eye", "planner") if picture else ("planner",)))


def load_source(
    path: Path, polarity: Polarity = "dark", clock: Callable[[], float] = time.perf_counter
) -> Scene:
    """The scene of any SOURCE; ``timings_ms`` gains ``load``: reading and decoding.

    ``polarity`` is for pictures: whether the obstacles are dark or light. Raises
    :class:`SceneError`, or a ValueError of ``vision``, naming the file.
    """
    begin_s = clock()
    data = read_bytes(path)
    if is_picture(data) or path.suffix.lower() in PICTURE_SUFFIXES:
        image, remarks = decode_picture(data, path)
        loaded_s = clock()
        scene = _extract(image, polarity, path)
        scene = replace(scene, remarks=(*remarks, *scene.remarks))
    else:
        scene = load_scene(path, read_picture=read_shades)
        loaded_s = clock()
    return replace(scene, timings_ms={"load": 1e3 * (loaded_s - begin_s), **scene.timings_ms})


def read_shades(path: Path) -> Shades:
    """A map's picture as shades in [0, 1] and a mask of its transparent pixels.

    The cells are those of the file: map servers heed no EXIF orientation.
    """
    image, doubts = _decode(read_bytes(path), path)
    if doubts:
        raise SceneError(f"{path}: {doubts[0]}")
    most = float(np.iinfo(image.dtype).max)
    if image.ndim == 2:
        return image / most, np.zeros(image.shape, dtype=np.bool_)
    colours = image[:, :, :3] if image.shape[2] >= 3 else image[:, :, :1]
    shade = colours.mean(axis=2, dtype=np.float64) / most
    clear = np.zeros(shade.shape, dtype=np.bool_)
    if image.shape[2] in (2, 4):
        clear = np.asarray(image[:, :, -1] < most, dtype=np.bool_)
    return shade, clear


def hold_points(scene: Scene, points: list[tuple[float, float]], room: float) -> Scene:
    """The scene with its derived bounds grown to hold the points with ``room`` around them.

    Bounds that the source gave are the arena's walls and stay as they are.
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
    """A file's picture as it is shown, and remarks: grey, BGR or BGRA, 8 or 16 bits a channel.

    It is turned as its EXIF orientation asks, as viewers and ``cv2.imread`` do. Raises
    :class:`SceneError`, naming the file, where ``data`` is no picture or a damaged one.
    """
    from vision.camera.picture_turn import orientation, turned

    image, remarks = _decode(data, path)
    told = orientation(data)
    if told == 1:
        return image, remarks
    return turned(image, told), (*remarks, f"turned as its EXIF orientation asks, {told}")


def _decode(data: bytes, path: Path) -> tuple[NDArray[Any], tuple[str, ...]]:
    """A file's picture as it is stored, and remarks."""
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


def _extract(image: NDArray[Any], polarity: Polarity, path: Path) -> Scene:
    import vision

    try:
        return vision.extract(image, polarity=polarity)
    except ValueError as error:
        raise SceneError(f"{path}: {error}") from error
