"""Calibrations of a run's cameras: from pixels to the floor. Metres, pixels."""

from __future__ import annotations

from navigation.config import Config
from navigation.config.several.each_camera import each_camera
from navigation.simulator.picture.pinhole import pinhole_of
from planner.scene import Bounds
from vision.calibration.calibration import Calibration
from vision.calibration.calibration_file import load_calibration
from vision.joined.floor_plan import FloorPlan


def calibration_of(config: Config) -> Calibration:
    """Configured calibration, or a simulated camera's true one if there is none."""
    camera = config.camera
    if camera.calibration is not None:
        return load_calibration(camera.calibration)
    if camera.metres_per_pixel is not None:
        return Calibration.from_scale(camera.metres_per_pixel, camera.size_px)
    return pinhole_of(config).calibration()


def floor_plan_of(config: Config) -> FloorPlan | None:
    """Floor under several cameras, else None; ``CalibrationError`` if one sees none of it."""
    cameras = each_camera(config)
    if not cameras:
        return None
    calibrations = [calibration_of(one) for one in cameras.values()]
    return FloorPlan.of(calibrations, Bounds(*config.arena.bounds_m), tuple(cameras))


def shown_calibration(config: Config, plan: FloorPlan | None) -> Calibration:
    """Calibration of the picture shown to people."""
    return calibration_of(config) if plan is None else plan.calibration
