"""Scene and map files in and out, recognised by content, a ROS map also by its suffix."""

from __future__ import annotations

import os
import re
from pathlib import Path

from planner.formats.map_files import (
    ReadPicture,
    decode,
    parse_movingai,
    read_bytes,
    read_ros_map,
)
from planner.formats.scene_json_reader import read_scene_json
from planner.formats.scene_text import HEADER, read_scene_text, write_scene_text
from planner.scene import Scene, SceneError

__all__ = [
    "is_picture",
    "load_scene",
    "read_scene_text",
    "save_scene",
    "write_scene_text",
]

_PICTURE_STARTS = (
    *(b"\x89PNG", b"\xff\xd8\xff", b"BM", b"GIF8", b"II*\x00", b"MM\x00*"),
    *(b"\xff\x4f\xff\x51", b"\x59\xa6\x6a\x95", b"#?RADIANCE", b"#?RGBE"),
)


def load_scene(path: str | os.PathLike[str], *, read_picture: ReadPicture | None = None) -> Scene:
    """Load a scene file; ``read_picture`` reads pictures of ROS maps other than PGM.

    Raises :class:`SceneError` with the file and, if known, line and column.
    """
    if not isinstance(path, str | os.PathLike):
        raise TypeError(f"path is a {type(path).__name__}: must be the name of a file")
    file = Path(path)
    return scene_from_bytes(read_bytes(file), file, read_picture=read_picture)


def scene_from_bytes(data: bytes, file: Path, *, read_picture: ReadPicture | None = None) -> Scene:
    """Parse a file's bytes like :func:`load_scene`; the picture of a ROS map is beside ``file``."""
    if is_picture(data):
        raise SceneError(
            f"{file}: a picture, not a scene: give it to vision.extract, or, for the picture of"
            " a ROS map, load its YAML file"
        )
    text = decode(data, str(file))
    if file.suffix.lower() in (".yaml", ".yml") or _looks_like_map_header(text):
        return read_ros_map(text, file, read_picture)
    if text.lstrip().startswith("{"):
        return read_scene_json(text, str(file))
    if re.match(r"\s*type\s+\w+\s*\n", text):
        return parse_movingai(text, str(file))
    return read_scene_text(text, str(file))


def save_scene(scene: Scene, path: str | os.PathLike[str]) -> None:
    """Write the scene as text; :class:`SceneError` if the file cannot be written."""
    text = write_scene_text(scene)
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise SceneError(f"{os.fspath(path)}: {error.strerror or error}") from None


def is_picture(data: bytes) -> bool:
    """True if a file with this beginning is a picture.

    PNG, JPEG, BMP, GIF, TIFF, WebP, AVIF, JPEG 2000, Netpbm, PFM, PAM, Radiance, Sun raster.
    """
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return True
    if data[4:11] == b"ftypavi" or data[4:8] == b"jP  ":
        return True
    words = re.match(rb"P[1-6Ff]\s+[\d#]|P7\s+[A-Z#]", data)
    return data.startswith(_PICTURE_STARTS) or words is not None


def _looks_like_map_header(text: str) -> bool:
    if text.startswith(HEADER):
        return False
    keys = set(re.findall(r"^(\w+)\s*:", text, flags=re.MULTILINE))
    return {"image", "resolution", "origin"} <= keys
