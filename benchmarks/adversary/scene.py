"""The arena, the missions and the configuration of one run.

The missions lead through the laboratory's narrow places, where a pose that is wrong by a few
centimetres is a contact. Metres, degrees.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from benchmarks.adversary.processes import ROOT
from navigation.config import Config, load_config
from navigation.simulator.picture.pinhole import pinhole_of
from vision.calibration.calibration_file import save_calibration

CONFIGS = ROOT / "configs"
CAMERA_RATE_HZ = 25.0


@dataclass(frozen=True, slots=True)
class Errand:
    """Where the robot starts, and the stations that it is sent to."""

    name: str
    start: tuple[float, float, float]
    stations: tuple[tuple[float, float], ...]


ERRANDS = (
    Errand("under the U", (0.30, 0.14, 0.0), ((1.35, 0.14), (1.74, 0.55), (1.70, 0.86))),
    Errand("past the bucket", (0.145, 0.50, 90.0), ((0.145, 1.16), (0.67, 1.30), (0.45, 0.85))),
)


DRIVER_ERRANDS = {
    "create2": Errand("through the hall", (0.40, 0.40, 45.0), ((1.44, 3.04), (2.84, 1.90))),
}
"""That of each robot behind a driver, in the arena of its own configuration."""


def write_driver_config(folder: Path, driver: str) -> Path:
    """The shipped configuration of a robot behind a driver, in ``folder``: the robot is elsewhere.

    Camera and arena are simulated as there.
    """
    base: dict[str, Any] = yaml.safe_load((CONFIGS / f"{driver}.yaml").read_text())
    base["camera"]["rate_hz"] = CAMERA_RATE_HZ
    base["serial"]["port"] = str(folder / "port")
    errand = DRIVER_ERRANDS[driver]
    base["mission"]["stations"] = [{"x_m": x, "y_m": y} for x, y in errand.stations]
    base["simulation"]["arena"] = str(CONFIGS / base["simulation"]["arena"])
    base["simulation"]["robot"] = {"poses": str(folder / "robot.pose")}
    base["recording"] = {"runs_dir": str(folder / "runs"), "journal": str(folder / "journal")}
    base["dashboard"] = {"enabled": False}
    file = folder / "run.yaml"
    file.write_text(yaml.safe_dump(base))
    return file


def write_config(
    folder: Path, errand: Errand, source: str = "simulated", page_port: int | None = None
) -> Path:
    """configs/hardware_in_the_loop.yaml with a camera of 640x480 and this errand, in ``folder``.

    ``source`` is the camera's; ``page_port`` serves the page there.
    """
    base: dict[str, Any] = yaml.safe_load((CONFIGS / "hardware_in_the_loop.yaml").read_text())
    x_m, y_m, heading_deg = errand.start
    base["camera"] = {"source": source, "size_px": [640, 480], "rate_hz": CAMERA_RATE_HZ}
    base["camera"]["calibration"] = str(folder / "calibration.yaml")
    base["serial"]["port"] = str(folder / "port")
    base["mission"]["stations"] = [{"x_m": x, "y_m": y} for x, y in errand.stations]
    base["simulation"] |= {
        "arena": str(CONFIGS / "arenas" / "laboratory.txt"),
        "start": {"x_m": x_m, "y_m": y_m, "heading_deg": heading_deg},
        "robot": {"poses": str(folder / "robot.pose")},
    }
    base["simulation"]["camera"] |= {"focal_px": 617.5, "centre_offset_px": [2.6, -1.9]}
    base["recording"] = {"runs_dir": str(folder / "runs"), "journal": str(folder / "journal")}
    base["recording"]["folder"] = str(folder / "recordings")
    base["dashboard"] = {"enabled": page_port is not None, "port": page_port or 0}
    file = folder / "run.yaml"
    _write_calibration(base, folder, file)
    file.write_text(yaml.safe_dump(base))
    return file


def _write_calibration(base: dict[str, Any], folder: Path, file: Path) -> None:
    """What a perfect calibration of the simulated camera gives."""
    seen = {**base, "camera": {**base["camera"], "source": "simulated", "calibration": None}}
    file.write_text(yaml.safe_dump(seen))
    save_calibration(pinhole_of(read_config(file)).calibration(), folder / "calibration.yaml")


def read_config(file: Path) -> Config:
    """A configuration without the environment's overrides."""
    return load_config(file, {})
