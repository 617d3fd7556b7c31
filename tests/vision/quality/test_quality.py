"""What is measured of a camera, against pictures that are made with it."""

from __future__ import annotations

import math
from itertools import pairwise

import cv2
import numpy as np
import pytest

from tests.support.drawn.boards import marker_patch, render
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame, Image
from vision.markers.marker_search import find_markers
from vision.quality import Watching
from vision.quality.brightness import clipped_of, flicker_of, noise_of
from vision.quality.focus import blur_across, blur_along, focus_of
from vision.quality.timing import even_times, timing_of


def stamps(rate_hz: float, count: int, jitter_s: float, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return 100.0 + np.arange(count) / rate_hz + rng.normal(0.0, jitter_s, count)


def test_rate_jitter_gaps_and_delay_are_those_of_the_stamps() -> None:
    times = np.delete(stamps(30.0, 300, 0.001), [50, 51, 120])
    timing = timing_of(times, times + 0.02)
    assert timing is not None
    assert timing.gaps == 3
    assert timing.rate_hz == pytest.approx(30.0 * 296 / 299, rel=1e-3)
    assert timing.jitter_s == pytest.approx(0.001, rel=0.2)
    assert timing.longest_gap_s == pytest.approx(0.1, abs=0.005)
    assert timing.delay_s == pytest.approx(0.02)
    assert timing_of(times[:2], times[:2]) is None


@pytest.mark.parametrize("sigma", [0.4, 1.0, 2.5, 8.0])
def test_noise_is_measured_beside_what_moves(sigma: float) -> None:
    rng = np.random.default_rng(1)
    floor = rng.uniform(60, 200, (240, 320))
    pictures = []
    for n in range(6):
        picture = floor + rng.normal(0.0, sigma, floor.shape)
        picture[40:90, 20 * n : 20 * n + 60] = 30
        pictures.append(np.clip(np.rint(picture), 0, 255).astype(np.uint8))
    found = noise_of([cv2.absdiff(a, b) for a, b in pairwise(pictures)])
    rounded = math.hypot(sigma, 1.0 / math.sqrt(12.0))
    assert found == pytest.approx(rounded, rel=0.12)


@pytest.mark.parametrize("lamp_hz", [100.0, 120.0])
@pytest.mark.parametrize("rate_hz", [29.97, 30.0, 25.0, 15.0, 27.3])
@pytest.mark.parametrize("readout_s", [0.0, 0.025])
def test_flicker_is_found_where_it_can_be_seen(
    lamp_hz: float, rate_hz: float, readout_s: float
) -> None:
    rng = np.random.default_rng(2)
    times = stamps(rate_hz, int(10 * rate_hz), 0.0015)
    exact = 100.0 + np.arange(len(times)) / rate_hz
    rows_s = readout_s * np.arange(200) / 200.0
    waves = np.sin(2.0 * math.pi * lamp_hz * (exact[:, None] + rows_s))
    rows = 120.0 * (1.0 + 0.03 * waves) + rng.normal(0.0, 0.2, (len(times), 200))
    found = flicker_of(even_times(times), rows)
    beat_hz = abs(math.remainder(lamp_hz, rate_hz))
    if beat_hz < 0.2:
        assert lamp_hz in found.unseen_hz
        return
    assert found.frequency_hz == lamp_hz
    assert found.share == pytest.approx(0.03, rel=0.25)


def test_a_steady_light_and_a_walking_person_are_no_flicker() -> None:
    rng = np.random.default_rng(3)
    times = stamps(29.0, 290, 0.001)
    rows = 120.0 + rng.normal(0.0, 0.2, (290, 200))
    rows += 10.0 * np.cumsum(rng.normal(0.0, 0.05, (290, 1)), axis=0)
    assert flicker_of(even_times(times), rows).share == 0.0


def edge(sigma: float, angle: float, noise: float = 2.0, step: float = 120.0) -> Image:
    y, x = np.mgrid[0:160, 0:160].astype(float)
    away = (x - 80.3) * math.cos(angle) + (y - 79.6) * math.sin(angle)
    light = 60.0 + step * 0.5 * (1.0 + np.vectorize(math.erf)(away / (sigma * math.sqrt(2.0))))
    rng = np.random.default_rng(4)
    return np.clip(np.rint(light + rng.normal(0.0, noise, light.shape)), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("sigma", [0.7, 1.0, 1.5, 2.5])
@pytest.mark.parametrize("angle", [0.0, 0.6, 2.2])
def test_the_blur_of_an_edge_is_its_sigma(sigma: float, angle: float) -> None:
    image = edge(sigma, angle)
    along = np.linspace(-40, 40, 40)
    points = np.stack([80 - along * math.sin(angle), 80 + along * math.cos(angle)], axis=1)
    normals = np.tile([math.cos(angle), math.sin(angle)], (40, 1))
    assert blur_across(image, points, normals) == pytest.approx(sigma, rel=0.15, abs=0.1)


def test_the_share_in_focus_is_of_the_tiles_with_edges() -> None:
    picture = np.full((480, 640), 210, np.uint8)
    for x in range(40, 620, 80):
        for y in range(40, 240, 80):
            cv2.rectangle(picture, (x, y), (x + 30, y + 30), 50, -1)
    sharp = cv2.GaussianBlur(picture, (0, 0), 0.8)
    blurred = cv2.GaussianBlur(picture, (0, 0), 3.0)
    picture = sharp.copy()
    picture[:, 320:] = blurred[:, 320:]
    focus = focus_of(picture)
    assert np.isnan(focus.blur_px[4:]).all(), "an empty floor cannot be judged"
    assert focus.sharp == pytest.approx(0.5, abs=0.08)
    assert focus_of(np.full((480, 640), 210, np.uint8)).sharp is None


def test_clipped_shares_are_of_the_arena_only() -> None:
    picture = np.full((100, 100), 120, np.uint8)
    picture[:10] = 255
    picture[90:] = 0
    mask = np.zeros((100, 100), np.uint8)
    mask[:50] = 255
    assert clipped_of(picture) == (0.1, 0.1)
    assert clipped_of(picture, mask) == (0.2, 0.0)


@pytest.mark.parametrize("blur_px", [0.8, 2.2])
def test_a_marker_s_blur_is_the_picture_s(blur_px: float) -> None:
    calibration = Calibration.from_scale(0.002, (360, 300))
    patch = marker_patch(cv2.aruco.DICT_4X4_50, 3, 0.16, (0.36, 0.3, 0.3), 0.0)
    rng = np.random.default_rng(5)
    clear = render(calibration, [patch], rng=rng, noise=0.0, samples=3)
    own_px = blur_along(clear, find_markers(clear, "DICT_4X4_50")[0][1])
    assert own_px is not None
    watching = Watching()
    for n in range(10):
        picture = cv2.GaussianBlur(clear, (0, 0), blur_px).astype(float)
        noisy = np.clip(picture + rng.normal(0, 2.0, picture.shape), 0, 255).astype(np.uint8)
        watching.add(Frame(noisy, 100.0 + n / 30.0, n, "test"), 100.01 + n / 30.0)
    quality = watching.judge("DICT_4X4_50")
    assert quality is not None
    assert [marker.id for marker in quality.markers] == [3]
    assert quality.markers[0].blur_px == pytest.approx(math.hypot(own_px, blur_px), rel=0.12)
    assert quality.noise_grey == pytest.approx(2.0, rel=0.15)


def test_a_single_picture_says_nothing_of_noise_flicker_or_rate() -> None:
    watching = Watching()
    assert watching.judge() is None
    picture = np.random.default_rng(6).integers(0, 255, (60, 80), dtype=np.uint8)
    for n in range(20):
        watching.add(Frame(picture, n / 10.0, n, "arena.png"), n / 10.0)
    quality = watching.judge()
    assert quality is not None
    assert (quality.noise_grey, quality.flicker) == (None, None)
