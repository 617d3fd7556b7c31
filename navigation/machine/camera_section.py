"""The best configuration section for a camera, and its insertion into a file.

Rules
- Automatic controls are fixed at the values found: focus always, exposure if lamps flicker or the
  robot would smear. Good settings stay as requested.
- A file keeps its comments, order and other keys; the new text is read again before the file is
  replaced.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from navigation.config.editing.in_file import ChangedMeanwhileError, write_source
from navigation.config.editing.in_text import EditError, value_text, with_values
from navigation.config.load import parse_config, read_source
from navigation.config.sections import Config
from navigation.machine.camera_findings import FLICKERS, SHARP_SHARE, SMEARED_PX, CameraMeasurements
from vision.camera.v4l2.controls import (
    AUTO_FOCUS,
    EXPOSURE,
    EXPOSURE_UNIT_MS,
    FOCUS,
    MAINS,
    CameraControl,
)
from vision.camera.v4l2.modes import rank_modes


class SectionError(ValueError):
    """A section that cannot be put into a file; the message says why, with advice."""


def best_section(judged: CameraMeasurements, source: str | int) -> dict[str, Any]:
    """Return the keys of ``camera`` and their values."""
    asked, quality = judged.asked, judged.quality
    section: dict[str, Any] = {
        "source": source,
        "size_px": list(quality.size),
        "rate_hz": asked.rate_hz,
    }
    if judged.kind != "device":
        return section
    best = rank_modes(judged.modes, quality.size, asked.rate_hz)
    if best and best[0].rate_hz is not None and best[0].rate_hz < 0.95 * asked.rate_hz:
        section["rate_hz"] = best[0].rate_hz
    section["format"] = asked.format
    by_id = {one.id: one for one in judged.controls}
    if MAINS in by_id:
        section["mains_hz"] = _mains_hz(judged)
    if EXPOSURE in by_id:
        section["exposure_ms"] = _exposure_ms(judged, by_id[EXPOSURE])
    for key in ("gain", "white_balance_k"):
        if (wanted := getattr(asked, key)) != "auto":
            section[key] = wanted
    focus = by_id.get(FOCUS)
    if focus is not None and AUTO_FOCUS in by_id:
        is_sharp = (quality.focus.sharp or 0.0) >= SHARP_SHARE
        found = is_sharp and focus.value is not None
        section["focus"] = float(focus.value) if found and focus.value is not None else asked.focus
    if asked.rolling_shutter_ms:
        section["rolling_shutter_ms"] = asked.rolling_shutter_ms
    return section


def _mains_hz(judged: CameraMeasurements) -> int:
    flicker = judged.quality.flicker
    if flicker is None or flicker.share <= 0.0:
        return judged.asked.mains_hz
    return round(flicker.frequency_hz / 2.0)


def _exposure_ms(judged: CameraMeasurements, has: CameraControl) -> float | str:
    """Requested exposure, or one that avoids flicker and smear."""
    asked, flicker = judged.asked.exposure_ms, judged.quality.flicker
    now_ms = judged.exposure_ms or 1000.0 / judged.asked.rate_hz
    least_ms, most_ms = has.least * EXPOSURE_UNIT_MS, has.most * EXPOSURE_UNIT_MS
    limit_ms = min(most_ms, 1000.0 / judged.asked.rate_hz)
    if judged.speed_m_s is not None and judged.metres_per_pixel is not None:
        limit_ms = min(limit_ms, 1000.0 * SMEARED_PX * judged.metres_per_pixel / judged.speed_m_s)
    step_ms = 500.0 / _mains_hz(judged)
    if flicker is not None and flicker.share > FLICKERS and step_ms <= limit_ms:
        return round(step_ms * max(1, int(min(now_ms, limit_ms) / step_ms)), 1)
    if now_ms > limit_ms:
        return round(max(limit_ms, least_ms), 1)
    return asked


def section_text(section: Mapping[str, Any]) -> str:
    """Text of the section in a configuration."""
    lines = [f"  {key}: {value_text(value)}" for key, value in section.items()]
    return "\n".join(["camera:", *lines]) + "\n"


def write_section(file: Path, section: Mapping[str, Any]) -> Config:
    """Put a section's keys into a configuration; on ``SectionError`` the file is unchanged."""
    text = read_source(file)
    try:
        changed = with_values(text, {("camera", key): value for key, value in section.items()})
    except EditError as error:
        raise SectionError(
            f"{file}: {error}; put it there by hand:\n" + section_text(section)
        ) from None
    config = parse_config(changed, str(file), file.parent, {})
    got = config.camera.model_dump(mode="json")
    for key, value in section.items():
        if got[key] != value:
            raise SectionError(
                f"{file}: camera.{key} would become {got[key]}, not {value}; "
                "put it there by hand:\n" + section_text(section)
            )
    try:
        write_source(file, changed, over=text)
    except ChangedMeanwhileError as error:
        raise SectionError(f"{error}; put it there by hand:\n" + section_text(section)) from None
    return config
