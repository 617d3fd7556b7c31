"""Calibrations as YAML files, with errors that name file, line and column.

Keys are those of ``vision.calibration.calibration.Calibration``; ``schema`` names the format.
Without ``lens_model`` it is Brown's. Unknown keys are errors.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from planner.scene import of_kind, printable
from vision.calibration.calibration import Calibration, CalibrationError, FloatArray

SCHEMA = "clearway.calibration/1"
LENS_SCHEMA = "clearway.lens/1"
"""Schema of a lens alone, which `clearway calibrate --lens` places."""

MOST_BYTES = 1 << 24
"""Most bytes of a file: a device has no end."""

_ROWS = {"camera_matrix": (3, 3), "arena_from_pixel": (3, 3)}
_REQUIRED = ("schema", "size", "camera_matrix", "distortion", "arena_from_pixel")
_LENS_REQUIRED = _REQUIRED[:-1]
_OPTIONAL = ("lens_model", "camera_center_m", "lens_rms_px", "arena_rms_m", "remarks")
_HEADER = """\
# Clearway: where pixels become metres. Pixel centres at integers; arena in metres, y up.
# The lens: camera_matrix, distortion (brown: k1, k2, p1, p2, k3; fisheye: k1, k2, k3, k4).
# arena_from_pixel: undistorted pixels to its floor. camera_center_m: the camera's x, y, height.
"""
_LENS_HEADER = """\
# Clearway: a camera's lens, not yet placed above an arena: calibrate --lens FILE --points ...
"""
_NO_FLOOR = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))
"""Placeholder for the floor of a lens alone."""


def save_calibration(calibration: Calibration, path: str | Path) -> None:
    """Write a calibration without loss; raises ``CalibrationError`` if that is impossible."""
    _write(path, calibration_text(calibration))


def save_lens(
    path: str | Path,
    size: tuple[int, int],
    camera_matrix: FloatArray,
    distortion: FloatArray,
    rms_px: float,
    lens_model: str = "brown",
) -> None:
    """Write a lens alone; raises ``CalibrationError`` if that is impossible."""
    values = {
        "schema": LENS_SCHEMA,
        "size": list(size),
        "camera_matrix": camera_matrix.tolist(),
        "distortion": distortion.tolist(),
        "lens_model": lens_model,
        "lens_rms_px": float(rms_px),
    }
    body = yaml.safe_dump(values, sort_keys=False, default_flow_style=None, width=100)
    _write(path, _LENS_HEADER + body)


def _write(path: str | Path, text: str) -> None:
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise CalibrationError(f"{path}: cannot be written: {error.strerror}") from error


def load_lens(path: str | Path) -> Calibration:
    """A lens alone, or that of a whole calibration; the floor of a lens alone is meaningless."""
    return parse_calibration(read_text(path), str(path), lens_alone=True)


def calibration_text(calibration: Calibration) -> str:
    """YAML text of a calibration, with floats that read back the same."""
    center = of_kind("calibration", calibration, Calibration).camera_center_m
    values: dict[str, Any] = {
        "schema": SCHEMA,
        "size": list(calibration.size),
        "camera_matrix": calibration.camera_matrix.tolist(),
        "distortion": calibration.distortion.tolist(),
        "lens_model": calibration.lens_model,
        "arena_from_pixel": calibration.arena_from_pixel.tolist(),
        "camera_center_m": None if center is None else [float(v) for v in center],
        "lens_rms_px": calibration.lens_rms_px,
        "arena_rms_m": calibration.arena_rms_m,
        "remarks": list(calibration.remarks),
    }
    body = yaml.safe_dump(values, sort_keys=False, default_flow_style=None, width=100)
    return _HEADER + body


def load_calibration(path: str | Path) -> Calibration:
    """Read a calibration; raises ``CalibrationError`` naming file, line and column."""
    return parse_calibration(read_text(path), str(path))


def read_text(path: str | Path) -> str:
    """Read a small text file, with or without a byte order mark.

    Raises ``CalibrationError`` if it cannot be read, is not text, or is too long.
    """
    try:
        with Path(path).open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise CalibrationError(f"{path}: cannot be read: {error.strerror}") from error
    if len(data) > MOST_BYTES:
        raise CalibrationError(f"{path}: more than {MOST_BYTES} bytes: must be at most that")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise CalibrationError(f"{path}: not a text file") from error


def parse_calibration(
    text: str, name: str = "calibration", *, lens_alone: bool = False
) -> Calibration:
    """Calibration from its YAML text; ``name`` is the file's name in messages.

    A lens alone is refused unless ``lens_alone`` is set.
    """
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"{name}:{mark.line + 1}:{mark.column + 1}" if mark else name
        raise CalibrationError(f"{where}: {error.problem or error.context}") from error
    except yaml.YAMLError as error:
        raise CalibrationError(f"{name}: no YAML: {str(error).splitlines()[0]}") from error
    except RecursionError:
        raise CalibrationError(f"{name}: no calibration: nested too deeply") from None
    if root is None:
        raise CalibrationError(f"{name}: an empty file, not a calibration")
    nodes = _entries(root, name)
    schema = _text(nodes["schema"], name, "schema") if "schema" in nodes else SCHEMA
    if schema == LENS_SCHEMA and not lens_alone:
        raise CalibrationError(
            f"{name}: holds a lens alone, which no arena can be seen by: place it with"
            f" clearway calibrate --lens {name} --points FILE or --floor-picture FILE"
        )
    is_lens = schema == LENS_SCHEMA
    for key in _LENS_REQUIRED if is_lens else _REQUIRED:
        if key not in nodes:
            raise CalibrationError(f"{_where(name, root)}: the key '{key}' is missing")
    if schema not in (SCHEMA, LENS_SCHEMA):
        raise CalibrationError(f"{_where(name, nodes['schema'])}: schema: must be {SCHEMA}")
    return _build(nodes, name)


def _build(nodes: Mapping[str, yaml.Node], name: str) -> Calibration:
    size = _numbers(nodes["size"], name, "size", 2)
    if any(v != int(v) for v in size):
        raise CalibrationError(f"{_where(name, nodes['size'])}: size: must be whole pixels")
    center = _optional(nodes, "camera_center_m")
    center_m = None if center is None else _numbers(center, name, "camera_center_m", 3)
    if center_m is not None and not center_m[2] > 0.0:
        raise CalibrationError(f"{_where(name, center)}: camera_center_m: the height must be > 0")
    try:
        return Calibration(
            size=(int(size[0]), int(size[1])),
            camera_matrix=_rows(nodes["camera_matrix"], name, "camera_matrix"),
            distortion=np.array(_numbers(nodes["distortion"], name, "distortion", None)),
            arena_from_pixel=_rows(nodes["arena_from_pixel"], name, "arena_from_pixel")
            if "arena_from_pixel" in nodes
            else np.array(_NO_FLOOR),
            camera_center_m=None if center_m is None else (center_m[0], center_m[1], center_m[2]),
            lens_rms_px=_residual(nodes, name, "lens_rms_px"),
            arena_rms_m=_residual(nodes, name, "arena_rms_m"),
            remarks=_remarks(nodes, name),
            lens_model=_text(nodes["lens_model"], name, "lens_model")
            if "lens_model" in nodes
            else "brown",
        )
    except CalibrationError as error:
        # an error of the whole calibration starts with its key
        key = str(error).split(":", 1)[0].split(" ", 1)[0]
        where = f"{_where(name, nodes[key])}: " if key in nodes else ""
        raise CalibrationError(f"{where}{error}") from error


def _entries(root: yaml.Node, name: str) -> dict[str, yaml.Node]:
    if not isinstance(root, yaml.MappingNode):
        raise CalibrationError(f"{_where(name, root)}: not a calibration: must be a mapping")
    entries: dict[str, yaml.Node] = {}
    for key, value in root.value:
        word = str(key.value)
        if word in entries:
            raise CalibrationError(f"{_where(name, key)}: {word[:40]!r} is given twice")
        if word not in _REQUIRED and word not in _OPTIONAL:
            raise CalibrationError(f"{_where(name, key)}: unknown key {word[:40]!r}")
        entries[word] = value
    return entries


def _where(name: str, node: yaml.Node | None) -> str:
    if node is None:
        return name
    return f"{name}:{node.start_mark.line + 1}:{node.start_mark.column + 1}"


def _text(node: yaml.Node, name: str, key: str) -> str:
    if not isinstance(node, yaml.ScalarNode):
        raise CalibrationError(f"{_where(name, node)}: {key}: must be text")
    return str(node.value)


def _number(node: yaml.Node, name: str, key: str) -> float:
    text = _text(node, name, key)
    try:
        value = float(text)
    except ValueError as error:
        raise CalibrationError(
            f"{_where(name, node)}: {key}: '{text[:24]}' is no number"
        ) from error
    if not math.isfinite(value):
        raise CalibrationError(f"{_where(name, node)}: {key}: {text}: must be finite")
    return value


def _numbers(node: yaml.Node, name: str, key: str, length: int | None) -> tuple[float, ...]:
    if not isinstance(node, yaml.SequenceNode):
        raise CalibrationError(f"{_where(name, node)}: {key}: must be a list of numbers")
    if length is not None and len(node.value) != length:
        raise CalibrationError(
            f"{_where(name, node)}: {key}: {len(node.value)} numbers: must be {length}"
        )
    return tuple(_number(item, name, key) for item in node.value)


def _rows(node: yaml.Node, name: str, key: str) -> FloatArray:
    rows, columns = _ROWS[key]
    if not isinstance(node, yaml.SequenceNode) or len(node.value) != rows:
        raise CalibrationError(f"{_where(name, node)}: {key}: must be {rows} rows of {columns}")
    return np.array([_numbers(row, name, key, columns) for row in node.value])


def _optional(nodes: Mapping[str, yaml.Node], key: str) -> yaml.Node | None:
    node = nodes.get(key)
    if isinstance(node, yaml.ScalarNode) and node.tag == "tag:yaml.org,2002:null":
        return None
    return node


def _residual(nodes: Mapping[str, yaml.Node], name: str, key: str) -> float | None:
    node = _optional(nodes, key)
    return None if node is None else _number(node, name, key)


def _remarks(nodes: Mapping[str, yaml.Node], name: str) -> tuple[str, ...]:
    node = _optional(nodes, "remarks")
    if node is None:
        return ()
    if not isinstance(node, yaml.SequenceNode):
        raise CalibrationError(f"{_where(name, node)}: remarks: must be a list of sentences")
    return tuple(printable(_text(item, name, "remarks")) for item in node.value)
