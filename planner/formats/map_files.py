"""Map files: the ROS map_server's YAML with its picture, and MovingAI's ``.map`` (Sturtevant 2012).

A cell's occupancy (Nav2 map_server, "map_io") is p = 1 - shade, or the shade if ``negate`` is set;
in ``raw`` mode the picture's byte in percent. It is occupied if p >= occupied_thresh, else free if
p <= free_thresh. All other cells are obstacles. map_saver writes the byte 205 for unknown, where p
= 0.196: in trinary mode without ``negate`` it remains unknown, even below ``free_thresh``.
``origin`` is the pose of the map's lower left corner, in metres and radians.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
import yaml
from numpy.typing import NDArray

from planner.formats.grid_maps import GridPose, grid_scene, map_scene
from planner.formats.pgm import parse_pgm
from planner.scene import Scene, SceneError

Shades: TypeAlias = tuple[NDArray[np.float64], NDArray[np.bool_]]
ReadPicture: TypeAlias = Callable[[Path], Shades]
"""A picture as (h, w) shades from 0, black, to 1, white, and a mask of transparent pixels."""

MAP_SAVER_UNKNOWN = 205
NAV2_OCCUPIED_THRESH, NAV2_FREE_THRESH = 0.65, 0.25
MOST_BYTES = 1 << 30
"""Bytes read of a file at most: a device or a sparse file may have no end."""
LEAST_RESOLUTION_M = 1e-6
"""Smaller cells would vanish beside an origin of 1e9 m."""
MOST_NAME = 255
"""Characters of a picture's name: errors name it in one readable sentence."""
PASSABLE, BLOCKED_SIGNS = ".GS", "@OTW"


@dataclass(frozen=True, slots=True)
class MapHeader:
    """Contents of a ROS map's YAML file."""

    image: str
    mode: str
    negate: bool
    occupied_thresh: float
    free_thresh: float
    pose: GridPose


def read_ros_map(text: str, path: Path, read_picture: ReadPicture | None = None) -> Scene:
    """Return the scene of a ROS map from its YAML, ``path``, and the picture in the same folder.

    ``read_picture`` reads pictures other than PGM. Raises :class:`SceneError` with the place.
    """
    free, unknown, remarks, pose = read_cells(text, path, read_picture)
    return map_scene(~free, pose, remarks, unknown)


def read_cells(
    text: str, path: Path, read_picture: ReadPicture | None
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], tuple[str, ...], GridPose]:
    """Certainly free cells, unknown cells, remarks on them, and the map's pose."""
    shade, transparent, header = read_map_picture(text, path, read_picture)
    return *classify(shade, transparent, header), header.pose


def read_map_picture(
    text: str, path: Path, read_picture: ReadPicture | None
) -> tuple[NDArray[np.float64], NDArray[np.bool_], MapHeader]:
    """Shades of a ROS map's cells, a mask of the transparent ones, and the header."""
    header = parse_map_header(text, str(path))
    picture = path.parent / header.image
    data = read_bytes(picture)
    if data[:2] in (b"P2", b"P5"):
        shade = parse_pgm(data, str(picture))
        return shade, np.zeros(shade.shape, dtype=np.bool_), header
    if read_picture is not None:
        return *read_picture(picture), header
    raise SceneError(f"{picture}: the picture of a map must be PGM (P2 or P5)")


def parse_map_header(text: str, name: str) -> MapHeader:
    """Parse the map's YAML; errors are :class:`SceneError` with line and column."""
    return _HeaderReader(text, name).read()


def classify(
    shade: NDArray[np.float64], transparent: NDArray[np.bool_], header: MapHeader
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], tuple[str, ...]]:
    """Certainly free cells, unknown cells, and remarks on them."""
    byte = np.rint(shade * 255.0)
    unknown = transparent.copy()
    if header.mode == "raw":
        occupancy = byte / 100.0
        unknown |= byte > 100.0
    else:
        # bytes over 255, so that 205 gives the same 0.196... as in the map server
        occupancy = shade if header.negate else (255.0 - shade * 255.0) / 255.0
    occupied = (occupancy >= header.occupied_thresh) & ~unknown
    below = (occupancy <= header.free_thresh) & ~unknown & ~occupied
    free = below
    remarks = []
    if header.mode == "trinary" and not header.negate:
        free = below & (byte != MAP_SAVER_UNKNOWN)
        kept = int(np.count_nonzero(below & ~free))
        if kept:
            remarks.append(
                f"{kept} cells of the value {MAP_SAVER_UNKNOWN}, which map_saver writes for"
                f" unknown, stay unknown though free_thresh {header.free_thresh:g} calls them free"
            )
    unknown = ~free & ~occupied
    count = int(np.count_nonzero(unknown))
    if count:
        remarks.append(f"{count} unknown cells are obstacles")
    return free, unknown, tuple(remarks)


def parse_movingai(text: str, name: str) -> Scene:
    """Return the scene of a MovingAI ``.map`` in units of cells, cell (i, j) at x = i, y = j."""
    lines = text.splitlines()
    fields: dict[str, str] = {}
    at = 0
    for at, line in enumerate(lines):
        words = line.split()
        if words == ["map"]:
            break
        if len(words) == 2:
            fields[words[0]] = words[1]
        elif words:
            raise SceneError(f"{name}:{at + 1}:1: expected 'type', 'height', 'width' or 'map'")
    else:
        raise SceneError(f"{name}:{len(lines)}:1: no line 'map' in this MovingAI map")
    height, width = (_map_side(fields, key, name) for key in ("height", "width"))
    rows = lines[at + 1 :]
    while rows and not rows[-1].strip():
        rows.pop()
    if len(rows) != height:
        raise SceneError(f"{name}:{at + 1}:1: height {height}, but {len(rows)} rows follow")
    for number, row in enumerate(rows, start=at + 2):
        row_text = row.rstrip()
        if len(row_text) != width:
            raise SceneError(f"{name}:{number}:1: width {width}, but {len(row_text)} cells")
        strange = re.search(f"[^{re.escape(PASSABLE + BLOCKED_SIGNS)}]", row_text)
        if strange:
            raise SceneError(
                f"{name}:{number}:{strange.start() + 1}: {strange.group()!r} is no cell: one of"
                f" {PASSABLE} (passable) or {BLOCKED_SIGNS} (not) is expected"
            )
    codes = np.frombuffer("".join(r.rstrip() for r in rows).encode("ascii"), dtype=np.uint8)
    passable = np.isin(codes, np.frombuffer(PASSABLE.encode("ascii"), dtype=np.uint8))
    return grid_scene(~passable.reshape(height, width))


def _map_side(fields: dict[str, str], key: str, name: str) -> int:
    word = fields.get(key, "nothing")
    if re.fullmatch(r"[0-9]{1,6}", word) is None or int(word) == 0:
        raise SceneError(f"{name}: {key} = {word[:24]}: must be a whole number in 1..999999")
    return int(word)


class _HeaderReader:
    def __init__(self, text: str, name: str) -> None:
        self.name = name
        try:
            node = yaml.compose(text, Loader=yaml.SafeLoader)
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark
            place = f":{mark.line + 1}:{mark.column + 1}" if mark else ""
            raise SceneError(f"{name}{place}: not YAML: {error.problem}") from None
        except (yaml.YAMLError, RecursionError) as error:
            raise SceneError(f"{name}: not YAML: {str(error).splitlines()[0]}") from None
        if not isinstance(node, yaml.MappingNode):
            raise SceneError(f"{name}:1:1: not the YAML of a ROS map: 'key: value' lines expected")
        self.nodes: dict[str, yaml.Node] = {}
        for key, value in node.value:
            word = str(key.value)
            if word in self.nodes:
                mark = key.start_mark
                place = f"{name}:{mark.line + 1}:{mark.column + 1}"
                raise SceneError(f"{place}: the key {word[:40]!r} is given twice")
            self.nodes[word] = value

    def error(self, key: str, what: str) -> SceneError:
        mark = self.nodes[key].start_mark
        return SceneError(f"{self.name}:{mark.line + 1}:{mark.column + 1}: {key}{what}")

    def read(self) -> MapHeader:
        for key in ("image", "resolution", "origin"):
            if key not in self.nodes:
                raise SceneError(f"{self.name}:1:1: a ROS map needs the key {key!r}")
        image = self.nodes["image"]
        if not isinstance(image, yaml.ScalarNode) or not image.value:
            raise self.error("image", ": must be a file name")
        if len(image.value) > MOST_NAME:
            said = f": a name of {len(image.value)} characters: must be at most {MOST_NAME}"
            raise self.error("image", said)
        resolution = self.number("resolution", self.nodes["resolution"])
        if resolution <= 0.0:
            raise self.error("resolution", f" = {resolution:g}: must be > 0")
        if resolution < LEAST_RESOLUTION_M:
            raise self.error(
                "resolution", f" = {resolution:g}: must be >= {LEAST_RESOLUTION_M:g} metres"
            )
        occupied = self.threshold("occupied_thresh", NAV2_OCCUPIED_THRESH)
        free = self.threshold("free_thresh", NAV2_FREE_THRESH)
        if free > occupied:
            raise SceneError(
                f"{self.name}: free_thresh {free:g} must be <= occupied_thresh {occupied:g}"
            )
        pose = GridPose(resolution, *self.origin())
        return MapHeader(str(image.value), self.mode(), self.negate(), occupied, free, pose)

    def number(self, key: str, node: yaml.Node) -> float:
        try:
            value = float(node.value)
        except (TypeError, ValueError):
            raise self.error(key, f" = {str(node.value)[:24]}: must be a number") from None
        if not math.isfinite(value) or abs(value) > 1e9:
            raise self.error(key, f" = {value:g}: must lie within +-1e9")
        return value

    def threshold(self, key: str, default: float) -> float:
        if key not in self.nodes:
            return default
        value = self.number(key, self.nodes[key])
        if not 0.0 <= value <= 1.0:
            raise self.error(key, f" = {value:g}: must lie in 0..1")
        return value

    def origin(self) -> tuple[float, float, float]:
        node = self.nodes["origin"]
        if not isinstance(node, yaml.SequenceNode) or len(node.value) != 3:
            raise self.error("origin", ": must be [x, y, yaw]")
        x, y, yaw = (self.number("origin", item) for item in node.value)
        return x, y, yaw

    def mode(self) -> str:
        if "mode" not in self.nodes:
            return "trinary"
        mode = str(self.nodes["mode"].value)
        if mode not in ("trinary", "scale", "raw"):
            raise self.error("mode", f" = {mode[:24]}: must be trinary, scale or raw")
        return mode

    def negate(self) -> bool:
        if "negate" not in self.nodes:
            return False
        word = str(self.nodes["negate"].value).lower()
        if word not in ("0", "1", "false", "true"):
            raise self.error("negate", f" = {word[:24]}: must be 0 or 1")
        return word in ("1", "true")


def read_bytes(path: Path) -> bytes:
    """Return the file's bytes; :class:`SceneError` if it cannot be read."""
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise SceneError(f"{path}: {error.strerror or error}") from None
    except ValueError as error:
        raise SceneError(f"{str(path)!r}: {error}") from None
    if len(data) > MOST_BYTES:
        raise SceneError(f"{path}: more than {MOST_BYTES} bytes: must be at most that")
    return data


def read_text(path: Path) -> str:
    """Return the file's text; :class:`SceneError` if it cannot be read or is not UTF-8."""
    return decode(read_bytes(path), str(path))


def decode(data: bytes, name: str) -> str:
    """Decode UTF-8 text without its byte order mark; :class:`SceneError` on NUL or other bytes."""
    try:
        text = data.decode("utf-8").removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        raise SceneError(f"{name}: not a text file: byte {error.start} is not UTF-8") from None
    if "\x00" in text:
        raise SceneError(f"{name}: not a text file: byte {data.index(0)} is NUL")
    return text
