"""Settings of a plugged-in camera, from the configuration's section."""

from __future__ import annotations

from navigation.config.sections import CameraSection
from vision.camera.sources import DeviceSettings
from vision.camera.v4l2.controls import CameraControls


def device_settings(camera: CameraSection, *, colour: bool = False) -> DeviceSettings:
    """Format and controls; grey pictures by default, since a run uses no others."""
    controls = CameraControls(
        exposure_ms=camera.exposure_ms,
        gain=camera.gain,
        focus=camera.focus,
        white_balance_k=camera.white_balance_k,
        mains_hz=camera.mains_hz,
    )
    return DeviceSettings(camera.format, controls, colour, camera.rolling_shutter_ms / 1000.0)
