"""Opens a camera, and watches it for some seconds."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from navigation.config import Config
from navigation.config.sections import CameraSection
from navigation.config.values import SIMULATED
from navigation.machine.camera_findings import CameraMeasurements
from navigation.run.calibrations import calibration_of
from navigation.run.devices.device_settings import device_settings
from navigation.run.world import World
from vision.calibration.calibration import Calibration
from vision.camera.camera import Camera, CameraError, Image
from vision.camera.capture import StreamCamera
from vision.camera.sources import camera_for
from vision.camera.v4l2.controls import CameraControl, list_controls
from vision.camera.v4l2.device import DeviceCamera
from vision.camera.v4l2.modes import CameraMode, list_modes, rate_text
from vision.quality import Watching

SETTLES_S: Final = 1.0
"""Time for automatic exposure, and for what a stream had kept: not counted."""
SILENT_S: Final = 5.0
"""A camera without a picture for this time has failed."""


@contextmanager
def opened_camera(wanted: CameraSection, config: Config | None) -> Iterator[Camera]:
    """The camera of a section, open; ``config`` is needed for a simulated one."""
    world: World | None = None
    if wanted.source == SIMULATED:
        if config is None:
            raise CameraError(
                "simulated: a simulated camera needs its configuration: name the file"
            )
        world = World(config)
        world.start()
        camera = world.open_camera()
    else:
        camera = camera_for(
            wanted.source, clock=time.monotonic, rate_hz=wanted.rate_hz, size=wanted.size_px,
            loop=True, device=device_settings(wanted),
        )  # fmt: skip
    try:
        camera.open()
        yield camera
    finally:
        camera.close()
        if world is not None:
            world.stop()


def watch(
    wanted: CameraSection,
    config: Config | None,
    seconds: float,
    tell: Callable[[str], None] = lambda _: None,
) -> CameraMeasurements:
    """Judge a camera over ``seconds``; ``CameraError`` if it fails."""
    calibration = None if config is None else calibration_of(config)
    watching = Watching(None if config is None else arena_mask(config))
    with opened_camera(wanted, config) as camera:
        kind = _kind(camera)
        _watch(camera, watching, seconds, 0.0 if kind == "file" else SETTLES_S, tell)
        tell("judging the pictures")
        modes, controls, taken = _abilities(camera)
        quality = watching.judge(None if config is None else config.robot.dictionary)
        if quality is None:
            raise CameraError(f"{camera.name}: gave no picture within {SILENT_S:g} s")
        return CameraMeasurements(
            asked=wanted,
            kind=kind,
            modes=modes,
            controls=controls,
            taken=taken,
            reason=camera.reason,
            damaged=camera.damaged if isinstance(camera, DeviceCamera) else 0,
            missing=camera.missing if isinstance(camera, DeviceCamera) else 0,
            quality=quality,
            metres_per_pixel=_scale(calibration, quality.size),
            speed_m_s=None if config is None else config.robot.speed_m_s,
            stale_s=0.2 if config is None else config.safety.frame_stale_s,
            any_size=config is None and "size_px" not in wanted.model_fields_set,
        )


def _watch(
    camera: Camera,
    watching: Watching,
    seconds: float,
    settles_s: float,
    tell: Callable[[str], None],
) -> None:
    last_s = time.monotonic()
    begins_s: float | None = None
    while begins_s is None or last_s < begins_s + seconds:
        frame, now_s = camera.read(0.5), time.monotonic()
        if frame is None:
            if camera.state == "ended":
                return
            if now_s - last_s > SILENT_S:
                raise CameraError(f"{camera.name}: no picture for {now_s - last_s:.1f} s")
            continue
        last_s = now_s
        if begins_s is None:
            begins_s = now_s + settles_s
        if now_s >= begins_s:
            watching.add(frame, now_s)
            tell(f"watching {camera.name}: {now_s - begins_s:.0f} of {seconds:g} s")
        else:
            tell(f"waiting for {camera.name} to settle")


def _kind(camera: Camera) -> str:
    if isinstance(camera, DeviceCamera):
        return "device"
    if isinstance(camera, StreamCamera):
        return "stream"
    return "file" if camera.may_repeat and camera.name != SIMULATED_NAME else "simulated"


SIMULATED_NAME: Final = "simulated camera"


def _abilities(camera: Camera) -> tuple[tuple[CameraMode, ...], tuple[CameraControl, ...], str]:
    if not isinstance(camera, DeviceCamera) or camera.node is None or camera.mode is None:
        return (), (), ""
    agreed = camera.mode
    rate = "" if agreed.rate_hz is None else f" at {rate_text(agreed.rate_hz)} frames/s"
    taken = f"{agreed.fourcc} {agreed.size[0]}x{agreed.size[1]}{rate}"
    try:
        modes = list_modes(camera.node, agreed.size)
        return tuple(modes), tuple(list_controls(camera.node)), taken
    except OSError as error:
        raise CameraError(f"{camera.name}: does not answer: {error.strerror or error}") from error


def arena_px(config: Config) -> NDArray[np.float64]:
    """The arena's border in the picture, (n, 2) pixels: a lens bends its sides."""
    x0, y0, x1, y1 = config.arena.bounds_m
    corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    shares = np.linspace(0.0, 1.0, 20, endpoint=False)[:, None]
    sides = [a + shares * (b - a) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)]
    return calibration_of(config).image_from_arena(np.concatenate(sides))


def arena_mask(config: Config) -> Image:
    """255 in the arena's part of the calibration's picture, (h, w)."""
    width, height = calibration_of(config).size
    mask: Any = np.zeros((height, width), np.uint8)
    cv2.fillPoly(mask, [np.rint(arena_px(config)).astype(np.int32)], 255)
    return np.asarray(mask, dtype=np.uint8)


def _scale(calibration: Calibration | None, size: tuple[int, int]) -> float | None:
    if calibration is None or tuple(calibration.size) != size:
        return None
    return float(calibration.metres_per_pixel)
