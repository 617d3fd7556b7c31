"""`clearway markers`: a picture's markers."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from navigation.cli.options import INPUT, OUTPUT, OutputType, format_option
from navigation.cli.outputs import CommandError, keep_apart, named, write_text

if TYPE_CHECKING:
    from vision.camera.camera import Image
    from vision.markers.reading import Marker

NONE_FOUND = 3
"""Exit code, the same as for no path: the picture is fine, and no marker is in it."""
GREEN, BLUE, RED = (60, 160, 30), (200, 90, 20), (40, 40, 220)


@click.command("markers")
@click.argument("image", type=INPUT)
@click.option("--dictionary", help="OpenCV's name, or a file in its format; all by default.")
@click.option("--calibration", type=INPUT, help="For poses on the floor, in metres.")
@click.option(
    "--height-m", type=float, default=0.0, show_default=True, help="Of the markers above the floor."
)
@format_option("A line a marker, or one JSON object.")
@click.option("-o", "--output", type=OUTPUT, help="Write the answer to this file.")
@click.option(
    "--render",
    type=OutputType(".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp"),
    help="Draw the corners over the picture: FILE.png.",
)
def command(
    image: Path,
    dictionary: str | None,
    calibration: Path | None,
    height_m: float,
    form: Literal["text", "json"],
    output: Path | None,
    render: Path | None,
) -> int:
    """Find the markers in IMAGE: id, dictionary, corners, and with --calibration the pose.

    Corners are pixels, x right, y down, pixel centres at integers, clockwise from the marker's own
    top left one. The exit code is 3 if there is no marker.
    """
    if not math.isfinite(height_m):
        raise click.BadParameter(f"{height_m}: must be finite", param_hint="--height-m")
    if height_m != 0.0 and calibration is None:
        raise click.BadParameter("is for --calibration only", param_hint="--height-m")
    keep_apart((("--output", output), ("--render", render)), (image,))

    import vision
    from navigation.cli.pictures.sources import decode_picture, read_source
    from vision.markers.marker_search import MarkerError

    picture, remarks = decode_picture(read_source(image), named(image))
    if picture.dtype != "uint8":
        picture = (picture >> 8).astype("uint8")
        remarks = (*remarks, "read with 8 of its 16 bits")
    picture = picture[:, :, :3] if picture.ndim == 3 and picture.shape[2] == 4 else picture
    model = None if calibration is None else vision.load_calibration(calibration)
    try:
        found = vision.find_markers(picture, dictionary, calibration=model, height_m=height_m)
    except MarkerError as error:
        raise CommandError(f"{named(image)}: {error}") from error
    size = (picture.shape[1], picture.shape[0])
    answer = _as_json(found, size) if form == "json" else _as_text(found)
    write_text(output, answer)
    for remark in remarks:
        click.echo(f"note: {image}: {remark}", err=True)
    if render is not None:
        _render(render, picture, found)
    if found:
        return 0
    click.echo(f"clearway: {image}: no marker found", err=True)
    return NONE_FOUND


def _as_json(found: Sequence[Marker], size: tuple[int, int]) -> str:
    markers = []
    for marker in found:
        one: dict[str, Any] = {
            "id": marker.id,
            "dictionary": marker.dictionary,
            "corners": marker.corners_px.tolist(),
            "agreement": marker.agreement,
            "refined": not marker.remark,
            "remark": marker.remark,
            "pose": None,
        }
        if marker.pose is not None:
            x, y, heading_rad = marker.pose
            one["pose"] = {"x_m": x, "y_m": y, "heading_rad": heading_rad, "size_m": marker.size_m}
        markers.append(one)
    body = {"schema": "clearway.markers/1", "size": size, "markers": markers}
    return json.dumps(body, indent=1) + "\n"


def _as_text(found: Sequence[Marker]) -> str:
    lines = []
    for marker in found:
        corners = " ".join(f"({x:.2f},{y:.2f})" for x, y in marker.corners_px)
        line = f"{marker.dictionary} {marker.id}: {corners} px"
        if marker.pose is not None and marker.size_m is not None:
            x, y, heading_rad = marker.pose
            line += (
                f"; at ({x:.4f}, {y:.4f}) m, {math.degrees(heading_rad):.2f} deg,"
                f" {1000.0 * marker.size_m:.1f} mm wide"
            )
        if marker.remark:
            line += f"; corners not refined: {marker.remark}"
        lines.append(line + "\n")
    return "".join(lines)


def _render(file: Path, picture: Image, found: Sequence[Marker]) -> None:
    import cv2
    import numpy as np

    drawn = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR) if picture.ndim == 2 else picture.copy()
    fine = 4
    width = max(1, round(min(drawn.shape[:2]) / 400))
    for marker in found:
        colour = RED if marker.remark else GREEN
        corners = np.rint(marker.corners_px * 2**fine).astype(np.int32)
        cv2.polylines(drawn, [corners], True, colour, width, cv2.LINE_AA, fine)
        first, second = (tuple(corner) for corner in corners[:2].tolist())
        cv2.line(drawn, first, second, BLUE, width + 1, cv2.LINE_AA, fine)
        x, y = marker.corners_px.mean(axis=0)
        side = float(np.linalg.norm(marker.corners_px[1] - marker.corners_px[0]))
        scale = max(side / 60.0, 0.4)
        text = str(marker.id)
        (wide, high), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 2)
        at = (round(x - wide / 2), round(y + high / 2))
        for thick, shade in ((4, (255, 255, 255)), (2, RED)):
            cv2.putText(drawn, text, at, cv2.FONT_HERSHEY_SIMPLEX, scale, shade, thick, cv2.LINE_AA)
    if not cv2.imwrite(str(file), drawn):
        raise CommandError(f"{file}: the picture cannot be written there")
