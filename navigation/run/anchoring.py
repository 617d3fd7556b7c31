"""Place a camera again from floor markers in its pictures, and rewrite its calibration file.

The file is replaced as a whole, and the old one is kept beside it. Metres, pixels.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Final

from navigation.config import Config
from navigation.config.several.each_camera import each_camera
from navigation.config.values import wrapped_rad
from navigation.mission.mission import MissionError
from navigation.shared.outside import printable
from navigation.shared.whole_file import UnwrittenFileError, write_whole
from vision.calibrate.lens import Lens
from vision.calibrate.reanchor import Anchor, Reanchored, reanchor
from vision.calibration.calibration import Calibration, CalibrationError, FloatArray
from vision.calibration.calibration_file import (
    calibration_text,
    parse_calibration,
    read_text,
    save_lens,
)
from vision.camera.camera import Frame, Image
from vision.markers.marker_search import MarkerError, grey_of
from vision.markers.reading import find_markers

NAME_CHARACTERS: Final = 64


class AnchoringError(ValueError):
    """Anchoring is impossible; the message says what is missing."""


@dataclass(frozen=True, slots=True, eq=False)
class Renewed:
    """Result of a renewal, with the file written and its backup."""

    found: Reanchored
    file: Path
    backup: Path

    def lines(self) -> list[str]:
        """Return lines for a person."""
        found = self.found
        used = sum(one.used for one in found.residuals)
        lines = [
            f"floor marker {one.id}: {one.rms_px:.2f} px{'' if one.used else ', left out'}"
            for one in found.residuals
        ]
        lines += [f"floor marker {one}: not seen" for one in found.missing]
        lines.append(
            f"anchored by {used} floor markers, {found.rms_px:.2f} px rms; the picture had moved "
            f"by {found.moved_px:.1f} px"
        )
        lines.append(f"written: {self.file}; the one before: {self.backup}")
        return lines


def of_camera(config: Config, name: str | None) -> Config:
    """Return the configuration of one camera; ``AnchoringError`` for a wrong or missing name."""
    cameras = each_camera(config)
    if name in cameras:
        return cameras[name]
    names = ", ".join(cameras) or "one, which has no name"
    if name is not None:
        raise AnchoringError(f"camera '{printable(name, NAME_CHARACTERS)}': there is {names}")
    if cameras:
        raise AnchoringError(f"there are several cameras: say which one (--camera: {names})")
    return config


def renew(
    config: Config, pictures: Sequence[Image], now: datetime, lens: Lens | None = None
) -> Renewed:
    """Place the configured camera again from the floor markers in its pictures.

    ``lens`` replaces the file's. Raises ``AnchoringError`` without file or markers, or if the
    pictures show too little.
    """
    file = config.camera.calibration
    if file is None:
        raise AnchoringError(
            "camera.calibration names no file: there is no lens to keep; make one by clearway "
            "calibrate"
        )
    anchors = _anchors(config)
    if not anchors:
        raise AnchoringError("arena.floor_markers: none has a place_m, so none says where it lies")
    try:
        before = read_text(file)
        calibration = parse_calibration(before, str(file))
        if lens is not None:
            calibration = _with_lens(calibration, lens)
        seen = [_corners(picture, config.robot.dictionary, calibration) for picture in pictures]
        found = reanchor(calibration, anchors, seen)
        backup = file.with_name(f"{file.stem}.{now:%Y%m%d-%H%M%S}{file.suffix}")
        write_whole(backup, before)
        write_whole(file, calibration_text(found.calibration))
    except (CalibrationError, MarkerError, UnwrittenFileError) as error:
        raise AnchoringError(str(error)) from error
    return Renewed(found, file, backup)


def _anchors(config: Config) -> list[Anchor]:
    return [
        Anchor(
            one.marker_id,
            one.place_m,
            one.size_m,
            None if one.heading_deg is None else wrapped_rad(one.heading_deg),
        )
        for one in config.arena.floor_markers
        if one.place_m is not None
    ]


def _with_lens(calibration: Calibration, lens: Lens) -> Calibration:
    if lens.size != calibration.size:
        raise CalibrationError(
            f"the lens is of {lens.size[0]} x {lens.size[1]} pixels: the calibration is of "
            f"{calibration.size[0]} x {calibration.size[1]}"
        )
    return replace(
        calibration,
        camera_matrix=lens.camera_matrix,
        distortion=lens.distortion,
        lens_model=lens.model,
        lens_rms_px=lens.rms_px,
    )


def take_over_lens(
    config: Config,
    lens: Lens,
    picture: Image | None,
    now: datetime,
    reload: Callable[[], None] | None,
) -> str:
    """Replace the lens, have the run take it over, and return the report.

    The floor markers in ``picture`` place the camera. If none has a known place, the lens alone is
    saved, beside the unchanged calibration. Raises ``AnchoringError``.
    """
    file = config.camera.calibration
    if file is None:
        raise AnchoringError("camera.calibration names no file")
    if not _anchors(config):
        alone = file.with_name(f"{file.stem}.lens.{now:%Y%m%d-%H%M%S}{file.suffix}")
        try:
            save_lens(
                alone, lens.size, lens.camera_matrix, lens.distortion, lens.rms_px, lens.model
            )
        except CalibrationError as error:
            raise AnchoringError(str(error)) from error
        return (
            f"the lens alone is saved as {alone.name}, and the run keeps the calibration that it "
            "has: arena.floor_markers has no marker with a place, so the camera is placed by "
            f"clearway calibrate --lens {alone.name} with --points or --floor-picture"
        )
    if picture is None:
        raise AnchoringError("no picture has come from the camera yet")
    lines = renew(config, [picture], now, lens).lines()
    if reload is None:
        return "; ".join([*lines, "start the run again: it still has the calibration before"])
    reload()
    return "; ".join([*lines, "the run begins again with it, and waits for orders"])


def _corners(picture: Image, dictionary: str, calibration: Calibration) -> dict[int, FloatArray]:
    """Corners of markers by id, without ids seen twice."""
    grey = grey_of(picture).view()
    grey.setflags(write=False)  # read-only as in a run: the kernels are compiled for that type
    found = find_markers(grey, dictionary, calibration=calibration)
    ids = [marker.id for marker in found]
    return {marker.id: marker.corners_px for marker in found if ids.count(marker.id) == 1}


def renew_while_running(
    config: Config,
    camera: str | None,
    newest: Callable[[str | None], Frame | None],
    reload: Callable[[], None] | None,
) -> list[str]:
    """Renew from a camera's newest picture and have the run take it over, or ``MissionError``."""
    try:
        meant = of_camera(config, camera)
        frame = newest(camera)
        if frame is None:
            raise MissionError("no picture has come from the camera yet")
        lines = renew(meant, [frame.image], datetime.now()).lines()
    except AnchoringError as error:
        raise MissionError(str(error)) from None
    if reload is None:
        return [*lines, "start the run again: it still has the calibration before"]
    reload()
    return [*lines, "the run begins again with it"]
