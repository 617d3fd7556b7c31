"""The section that serves a camera best, what is said of it, and putting it into a file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from navigation.config.sections import CameraSection
from navigation.machine.camera_findings import CameraMeasurements, camera_findings
from navigation.machine.camera_section import (
    SectionError,
    best_section,
    section_text,
    write_section,
)
from navigation.machine.doctor import Finding
from tests.support.processes.v4l2_preloaded import ROOT
from vision.camera.v4l2 import controls
from vision.camera.v4l2.controls import CameraControl
from vision.camera.v4l2.modes import CameraMode
from vision.quality import Quality
from vision.quality.brightness import Flicker
from vision.quality.focus import Focus
from vision.quality.timing import Timing

SIMULATION = (ROOT / "configs" / "simulation.yaml").read_text()


def judged(
    exposure_ms: float = 25.0, flicker: Flicker | None = None, sharp: bool = True
) -> CameraMeasurements:
    quality = Quality(
        picture=np.full((960, 1280), 120, np.uint8),
        size=(1280, 960),
        timing=Timing(300, 10.0, 30.0, 0.001, 0.04, 0, 0.02),
        noise_grey=2.0,
        flicker=flicker or Flicker(0.0, 0.0, ()),
        brightness=120.0,
        white=0.0,
        black=0.0,
        focus=Focus(np.full((6, 8), 0.8 if sharp else 2.5)),
        markers=(),
    )
    listed = (
        CameraControl(controls.MAINS, "Power Line Frequency", 0, 2, 1, 1, 1),
        CameraControl(controls.EXPOSURE, "Exposure", 3, 2047, 1, 250, round(10 * exposure_ms)),
        CameraControl(controls.FOCUS, "Focus, Absolute", 0, 250, 5, 0, 35),
        CameraControl(controls.AUTO_FOCUS, "Focus, Automatic", 0, 1, 1, 1, 1),
    )
    asked = CameraSection(source=0)
    modes = (CameraMode("YUYV", (1280, 960), (10.0,)), CameraMode("MJPG", (1280, 960), (30.0,)))
    return CameraMeasurements(asked, "device", modes, listed, "MJPG", "", 0, 0, quality, 0.002, 0.3)


def by_name(of: CameraMeasurements) -> dict[str, Finding]:
    return {finding.name: finding for finding in camera_findings(of)}


def test_what_is_well_stays_as_asked_and_focus_is_fixed_where_it_is() -> None:
    section = best_section(judged(exposure_ms=5.0), 0)
    assert section["exposure_ms"] == "auto"
    assert section["focus"] == 35.0
    assert best_section(judged(sharp=False), 0)["focus"] == "auto"


@pytest.mark.parametrize(("hz", "mains", "exposure_ms"), [(100.0, 50, 10.0), (120.0, 60, 8.3)])
def test_flickering_lamps_are_answered_with_a_multiple_of_their_time(
    hz: float, mains: int, exposure_ms: float
) -> None:
    one = judged(exposure_ms=12.0, flicker=Flicker(hz, 0.05, ()))
    section = best_section(one, 0)
    assert (section["mains_hz"], section["exposure_ms"]) == (mains, exposure_ms)
    finding = by_name(one)["flicker"]
    assert finding.status == "warn"
    assert f"camera.mains_hz {mains}" in finding.cure


def test_an_exposure_in_which_a_marker_smears_is_shortened() -> None:
    """0.3 m/s at 2 mm a pixel: 2 px in 13.3 ms."""
    one = judged(exposure_ms=25.0)
    assert best_section(one, 0)["exposure_ms"] == 13.3
    assert by_name(one)["motion"].cure == "camera.exposure_ms <= 13.3, and more light"
    assert by_name(judged(exposure_ms=5.0))["motion"].status == "ok"


def test_a_camera_that_is_too_slow_is_told_why() -> None:
    one = judged(exposure_ms=5.0)
    timing = Timing(100, 10.0, 10.0, 0.001, 0.3, 3, 0.02)
    slow = replace(one, quality=replace(one.quality, timing=timing))
    assert "close other programs" in by_name(slow)["rate"].cure
    raw = replace(slow, asked=slow.asked.model_copy(update={"format": "yuyv"}))
    assert by_name(raw)["rate"].cure == "set camera.format to auto: MJPG reaches the rate"
    none = replace(slow, modes=slow.modes[:1])
    assert by_name(none)["rate"].cure == "lower camera.size_px: at this size it offers 10 frames/s"
    dark = replace(slow, controls=judged(exposure_ms=90.0).controls)
    assert "it exposes 90 ms" in by_name(dark)["rate"].cure
    assert "the robot holds after 0.2 s" in by_name(slow)["jitter"].cure
    assert best_section(none, 0)["rate_hz"] == 10.0


def test_a_written_section_keeps_comments_and_other_keys(tmp_path: Path) -> None:
    file = tmp_path / "arena.yaml"
    text = SIMULATION.replace("  calibration: simulation_calibration.yaml\n", "")
    file.write_text(text)
    section = {"source": "simulated", "rate_hz": 25.0, "exposure_ms": 8.3, "focus": "auto"}
    config = write_section(file, section)
    assert (config.camera.rate_hz, config.camera.exposure_ms) == (25.0, 8.3)
    before, after = text.splitlines(), file.read_text().splitlines()
    assert set(after) - set(before) == {"  rate_hz: 25", "  exposure_ms: 8.3", "  focus: auto"}
    assert set(before) - set(after) == {"  rate_hz: 30"}
    write_section(file, section)
    assert file.read_text().splitlines() == after, "written twice is written once"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("  rate_hz: 30\n", "  rate_hz: &rate 30\n  noise_grey: *rate\n"),
        ("  rate_hz: 30\n", "  rate_hz: [30]\n  x: 1\n"),
    ],
)
def test_a_file_that_cannot_be_changed_is_left_as_it_is(tmp_path: Path, old: str, new: str) -> None:
    file = tmp_path / "arena.yaml"
    file.write_text(SIMULATION.replace(old, new))
    before = file.read_text()
    with pytest.raises(ValueError, match=r"arena\.yaml"):
        write_section(file, {"source": "simulated", "rate_hz": 25.0})
    assert file.read_text() == before


def test_a_section_on_one_line_and_a_value_below_its_key_are_changed_too(tmp_path: Path) -> None:
    file = tmp_path / "arena.yaml"
    file.write_text(SIMULATION.replace("  rate_hz: 30\n", "  rate_hz:\n    30\n"))
    assert write_section(file, {"rate_hz": 25.0}).camera.rate_hz == 25.0


def test_the_section_s_text_is_a_configuration_s() -> None:
    text = section_text({"source": "/dev/v4l/by-id/usb-a", "size_px": [640, 480], "focus": 35.0})
    assert text == "camera:\n  source: /dev/v4l/by-id/usb-a\n  size_px: [640, 480]\n  focus: 35\n"
    assert issubclass(SectionError, ValueError)
