"""Findings on a camera for a run, each a sentence with advice.

Grey levels, pixels, seconds, metres; shares are of one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from navigation.config.sections import CameraSection
from navigation.machine.doctor import Finding
from vision.camera.v4l2.controls import (
    DYNAMIC_RATE,
    EXPOSURE,
    EXPOSURE_UNIT_MS,
    CameraControl,
)
from vision.camera.v4l2.modes import REACHES, CameraMode, rank_modes
from vision.quality import Quality
from vision.quality.focus import SHARP_PX

NOISY: Final = 6.0
"""Grey levels: outlines are found to a tenth of a pixel with 2.5, and worse in proportion."""
FLICKERS: Final = 0.01
"""Flicker as a share of the brightness: more is a change of light to the watch over the arena."""
CLIPS: Final = 0.01
DARK_CLIPS: Final = 0.3
"""Black obstacles may be wholly black; a third of the picture is an exposure that is too short."""
LEAST_BRIGHTNESS, MOST_BRIGHTNESS = 50.0, 220.0
SHARP_SHARE: Final = 0.9
SMEARED_PX: Final = 2.0
"""A marker's cell of six pixels keeps a plateau of four."""


@dataclass(frozen=True, slots=True)
class CameraMeasurements:
    """Measurements of a camera, empty or None if its source lacks them."""

    asked: CameraSection
    kind: str
    """``device``, ``stream``, ``file`` or ``simulated``."""
    modes: tuple[CameraMode, ...]
    controls: tuple[CameraControl, ...]
    taken: str
    """Format, size and rate agreed on with a device: ``MJPG 1280x960 at 30 frames/s``."""
    reason: str
    """Remark of the camera itself, on controls refused and the like."""
    damaged: int
    missing: int
    quality: Quality
    metres_per_pixel: float | None = None
    speed_m_s: float | None = None
    stale_s: float = 0.2
    any_size: bool = False
    """True if no size was requested: the source's own is right."""

    @property
    def exposure_ms(self) -> float | None:
        """Exposure time in use, automatic or not; None if the driver does not report it."""
        for control in self.controls:
            if control.id == EXPOSURE and control.value is not None:
                return control.value * EXPOSURE_UNIT_MS
        return None


def camera_findings(judged: CameraMeasurements) -> list[Finding]:
    """One sentence on each measurement, or on why it is impossible."""
    return [
        *_size(judged), *_rate(judged), *_regularity(judged), *_delay(judged), *_damage(judged),
        *_noise(judged), *_flicker(judged), *_light(judged), *_focus(judged), *_markers(judged),
        *_smear(judged), *_said(judged),
    ]  # fmt: skip


def _size(judged: CameraMeasurements) -> Iterator[Finding]:
    (width, height), (w, h) = judged.quality.size, judged.asked.size_px
    told = f"{width}x{height}"
    if judged.any_size or judged.quality.size == judged.asked.size_px:
        yield Finding("ok", "size", told)
        return
    cure = f"set camera.size_px to [{width}, {height}], and calibrate at this size"
    yield Finding("fail", "size", f"{told}, camera.size_px asks for {w}x{h}", cure)


def _rate(judged: CameraMeasurements) -> Iterator[Finding]:
    timing = judged.quality.timing
    if timing is None:
        yield Finding("warn", "rate", "too few pictures to measure it", "watch for longer")
        return
    told = f"{timing.rate_hz:.1f} frames/s over {timing.seconds:.1f} s"
    if judged.kind == "file":
        yield Finding("ok", "rate", f"{told}: the pace at which a file is read")
        return
    wanted_hz = judged.asked.rate_hz
    if timing.rate_hz >= REACHES * wanted_hz:
        yield Finding("ok", "rate", told)
        return
    yield Finding("warn", "rate", f"{told}, camera.rate_hz asks for {wanted_hz:g}", _faster(judged))


def _faster(judged: CameraMeasurements) -> str:
    asked = judged.asked
    best = rank_modes(judged.modes, asked.size_px, asked.rate_hz)
    reaches = best and best[0].rate_hz is not None and best[0].rate_hz >= REACHES * asked.rate_hz
    if reaches and asked.format != "auto":
        return f"set camera.format to auto: {best[0].fourcc} reaches the rate"
    if best and not reaches and best[0].rate_hz is not None:
        return f"lower camera.size_px: at this size it offers {best[0].rate_hz:g} frames/s"
    slow_ms = 1000.0 / asked.rate_hz
    exposure_ms = judged.exposure_ms
    if exposure_ms is not None and exposure_ms > slow_ms:
        return f"more light, or camera.exposure_ms <= {slow_ms:.0f}: it exposes {exposure_ms:g} ms"
    if any(one.id == DYNAMIC_RATE and one.value for one in judged.controls):
        return "automatic exposure lowers the rate: more light, or a fixed camera.exposure_ms"
    if judged.kind == "stream":
        return "raise the rate in the camera's own settings, or use a wired network"
    if judged.kind == "simulated":
        return "this machine is busy, or too slow to draw the pictures"
    return "more light; a USB port of its own; close other programs"


def _regularity(judged: CameraMeasurements) -> Iterator[Finding]:
    timing = judged.quality.timing
    if timing is None or judged.kind == "file":
        return
    gap_ms = 1000.0 * timing.longest_gap_s
    told = f"{1000.0 * timing.jitter_s:.1f} ms of jitter, the longest gap {gap_ms:.0f} ms"
    lost = f", {timing.gaps} pictures are missing" if timing.gaps else ""
    if timing.longest_gap_s > judged.stale_s:
        cure = (
            f"the robot holds after {judged.stale_s:g} s without a picture: a USB port of its own"
        )
        yield Finding("warn", "jitter", told + lost, cure)
    else:
        yield Finding("ok", "jitter", told + lost)


def _delay(judged: CameraMeasurements) -> Iterator[Finding]:
    timing = judged.quality.timing
    if timing is None or judged.kind == "file":
        return
    whole = "a run measures the whole by the robot's motion"
    delay_ms = 1000.0 * timing.delay_s
    if judged.kind == "stream":
        yield Finding("ok", "delay", f"a stream does not say how old its pictures are; {whole}")
    elif judged.kind == "simulated":
        yield Finding("ok", "delay", f"{delay_ms:.0f} ms from the exposure to the program")
    else:
        told = f"{delay_ms:.0f} ms from the driver's stamp to the program; {whole}"
        yield Finding("ok", "delay", told)


def _damage(judged: CameraMeasurements) -> Iterator[Finding]:
    if judged.kind != "device":
        return
    count = judged.quality.timing.pictures if judged.quality.timing else 0
    if judged.damaged > 0.01 * max(count, 1):
        cure = "a shorter cable, or another USB port; no hub"
        yield Finding("warn", "damage", f"{judged.damaged} damaged pictures of {count}", cure)
    elif judged.damaged:
        yield Finding("ok", "damage", f"{judged.damaged} damaged pictures of {count}, dropped")
    else:
        yield Finding("ok", "damage", "no damaged picture")


def _noise(judged: CameraMeasurements) -> Iterator[Finding]:
    noise = judged.quality.noise_grey
    if noise is None:
        yield Finding("ok", "noise", "cannot be measured: the pictures do not change")
    elif noise > NOISY:
        cure = "more light, a longer camera.exposure_ms, or a lower camera.gain"
        yield Finding("warn", "noise", f"{noise:.1f} grey levels", cure)
    else:
        yield Finding("ok", "noise", f"{noise:.1f} grey levels")


def _flicker(judged: CameraMeasurements) -> Iterator[Finding]:
    flicker = judged.quality.flicker
    if judged.kind == "file":
        yield Finding("ok", "flicker", "a file's pace is not its camera's: cannot be measured")
        return
    if flicker is None:
        yield Finding("ok", "flicker", "cannot be measured: the pictures do not change")
        return
    hidden = " or ".join(f"{each:g}" for each in flicker.unseen_hz)
    unseen = f"of {hidden} Hz would stand still at this rate, and cannot be seen" if hidden else ""
    if flicker.share > FLICKERS:
        step_ms = 1000.0 / flicker.frequency_hz
        mains = f"camera.mains_hz {flicker.frequency_hz / 2.0:g}"
        told = f"{100.0 * flicker.share:.1f} % of the brightness at {flicker.frequency_hz:g} Hz"
        cure = f"{mains}, and camera.exposure_ms a multiple of {step_ms:.4g}; or other lamps"
        yield Finding("warn", "flicker", told, cure)
    elif flicker.share > 0.0:
        told = f"{100.0 * flicker.share:.1f} % of the brightness at {flicker.frequency_hz:g} Hz"
        yield Finding("ok", "flicker", f"{told}: harmless")
    elif len(flicker.unseen_hz) == 2:
        yield Finding("ok", "flicker", f"{unseen}; watch for longer")
    else:
        yield Finding("ok", "flicker", f"none seen; {unseen}" if unseen else "none seen")


def _light(judged: CameraMeasurements) -> Iterator[Finding]:
    quality = judged.quality
    if quality.white > CLIPS:
        told = f"{100.0 * quality.white:.1f} % of the pixels are white beyond measure"
        cure = "a shorter camera.exposure_ms; turn lamps so that they do not mirror in the floor"
        yield Finding("warn", "clipping", told, cure)
    elif quality.black > DARK_CLIPS:
        told = f"{100.0 * quality.black:.0f} % of the pixels are black beyond measure"
        yield Finding("warn", "clipping", told, "more light, or a longer camera.exposure_ms")
    else:
        told = f"{100.0 * quality.white:.1f} % white, {100.0 * quality.black:.1f} % black"
        yield Finding("ok", "clipping", told)
    told = f"a mean of {quality.brightness:.0f} of 255"
    if LEAST_BRIGHTNESS <= quality.brightness <= MOST_BRIGHTNESS:
        yield Finding("ok", "brightness", told)
    elif quality.brightness < LEAST_BRIGHTNESS:
        cure = "more light, a longer camera.exposure_ms or a higher camera.gain"
        yield Finding("warn", "brightness", told, cure)
    else:
        yield Finding("warn", "brightness", told, "a shorter camera.exposure_ms or less light")


def _focus(judged: CameraMeasurements) -> Iterator[Finding]:
    focus = judged.quality.focus
    sharp, blur_px = focus.sharp, focus.median_px
    if sharp is None or blur_px is None:
        cure = "lay printed sheets or markers on the floor, and look again"
        yield Finding("warn", "focus", "cannot be judged: there is no clear edge", cure)
        return
    seen = f"{100.0 * focus.judged:.0f} % of the picture has edges to judge"
    told = f"{100.0 * sharp:.0f} % of it is in focus, edges blur by {blur_px:.1f} px; {seen}"
    if sharp >= SHARP_SHARE:
        yield Finding("ok", "focus", told)
        return
    adjustable = any("focus" in one.name.lower() for one in judged.controls)
    cure = (
        "set camera.focus to a number at which the floor is sharp" if adjustable
        else "turn the lens until edges on the floor are sharp; clean it"
    )  # fmt: skip
    yield Finding("warn", "focus", told, cure)


def _markers(judged: CameraMeasurements) -> Iterator[Finding]:
    markers = judged.quality.markers
    if not markers:
        yield Finding("ok", "marker", "none is in view: put the robot there to judge it")
    for marker in markers:
        name = f"marker {marker.id}"
        if marker.blur_px is None:
            told, cure = "its sides cannot be judged", "leave a white margin around it"
            yield Finding("warn", name, told, cure)
        elif marker.blur_px > SHARP_PX:
            cure = "focus the lens; a robot that moves: a shorter camera.exposure_ms"
            yield Finding("warn", name, f"blurred by {marker.blur_px:.1f} px", cure)
        else:
            yield Finding("ok", name, f"blurred by {marker.blur_px:.1f} px")


def _smear(judged: CameraMeasurements) -> Iterator[Finding]:
    """Smear of a marker at the robot's full speed, if known."""
    exposure_ms, speed_m_s = judged.exposure_ms, judged.speed_m_s
    if exposure_ms is None or speed_m_s is None or judged.metres_per_pixel is None:
        return
    pixels_a_ms = speed_m_s / judged.metres_per_pixel / 1000.0
    smear_px = exposure_ms * pixels_a_ms
    told = f"at {speed_m_s:g} m/s a marker smears by {smear_px:.1f} px in {exposure_ms:g} ms"
    if smear_px <= SMEARED_PX:
        yield Finding("ok", "motion", told)
    else:
        limit_ms = SMEARED_PX / pixels_a_ms
        yield Finding(
            "warn", "motion", told, f"camera.exposure_ms <= {limit_ms:.1f}, and more light"
        )


def _said(judged: CameraMeasurements) -> Iterator[Finding]:
    if judged.kind == "device" and judged.reason:
        cure = "choose what the camera has: the table above lists it"
        yield Finding("warn", "settings", judged.reason, cure)
