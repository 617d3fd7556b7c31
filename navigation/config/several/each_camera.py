"""Splits a configuration of several cameras into one for each."""

from __future__ import annotations

from navigation.config.sections import CameraEntry, CameraSection, Config
from navigation.config.simulation import SimulationSection
from navigation.config.values import with_own


def camera_of(camera: CameraSection, entry: CameraEntry) -> CameraSection:
    """``camera`` with the differences of an entry; one with its own calibration has no scale."""
    own = with_own(camera, entry)
    return own if entry.calibration is None else own.model_copy(update={"metres_per_pixel": None})


def each_camera(config: Config) -> dict[str, Config]:
    """Configuration of each of several cameras as if it were alone, by name; else empty."""
    return {
        entry.name: config.model_copy(
            update={
                "camera": camera_of(config.camera, entry),
                "cameras": (),
                "simulation": _simulation_of(config.simulation, entry, index),
            }
        )
        for index, entry in enumerate(config.cameras)
    }


def _simulation_of(
    simulation: SimulationSection | None, entry: CameraEntry, index: int
) -> SimulationSection | None:
    if simulation is None:
        return None
    camera = simulation.camera
    for one in simulation.cameras:
        if one.name == entry.name:
            camera = with_own(camera, one)
    # each sensor has its own noise
    update = {"camera": camera, "cameras": (), "seed": simulation.seed + index}
    return simulation.model_copy(update=update)
