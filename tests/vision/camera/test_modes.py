"""Which of a camera's modes is chosen, and its buffers as pictures."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vision.camera.v4l2.modes import (
    ORDER,
    REACHES,
    CameraMode,
    fourcc_code,
    fourcc_text,
    rank_modes,
)
from vision.camera.v4l2.pixels import picture_of

SIZE = (64, 48)
RATES = st.lists(st.sampled_from([5.0, 10.0, 15.0, 29.97, 30.0, 60.0]), max_size=3)
MODES = st.lists(
    st.builds(
        CameraMode,
        st.sampled_from([*ORDER, "H264"]),
        st.sampled_from([(640, 480), (1280, 960), (1920, 1080)]),
        RATES.map(lambda rates: tuple(sorted(rates, reverse=True))),
    ),
    max_size=8,
)


@given(MODES, st.sampled_from([15.0, 30.0, None]))
def test_the_first_choice_reaches_the_rate_if_any_does_and_has_the_best_of_their_formats(
    modes: list[CameraMode], rate_hz: float | None
) -> None:
    size = (1280, 960)
    ranked = rank_modes(modes, size, rate_hz)
    assert len(ranked) == len([mode for mode in modes if mode.fourcc in ORDER])
    fits = [mode for mode in modes if mode.size == size and mode.fourcc in ORDER]
    if not fits:
        return
    first = ranked[0]
    assert first.size == size
    if rate_hz is None:
        return
    enough = [m for m in fits if not m.rates_hz or max(m.rates_hz) >= REACHES * rate_hz]
    if enough:
        assert first.rate_hz is not None
        assert first.rate_hz >= REACHES * rate_hz
        assert all(ORDER.index(first.fourcc) <= ORDER.index(mode.fourcc) for mode in enough)
    else:
        assert first.rate_hz == max(max(mode.rates_hz) for mode in fits)


def test_the_slowest_rate_that_is_enough_is_asked_for() -> None:
    modes = [CameraMode("YUYV", (640, 480), (60.0, 30.0, 15.0))]
    assert rank_modes(modes, (640, 480), 25.0)[0].rate_hz == 30.0
    assert rank_modes(modes, (640, 480), 90.0)[0].rate_hz == 60.0


@given(st.text("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789", min_size=3, max_size=4))
def test_four_letters_and_their_number_are_one(text: str) -> None:
    assert fourcc_text(fourcc_code(text)) == text


def noisy(colour: bool) -> np.ndarray:
    rng = np.random.default_rng(1)
    shape = (SIZE[1], SIZE[0], 3) if colour else (SIZE[1], SIZE[0])
    return cv2.GaussianBlur(rng.integers(0, 256, shape, dtype=np.uint8), (0, 0), 4)


PACKS = {
    "YUYV": cv2.COLOR_BGR2YUV_YUY2,
    "UYVY": cv2.COLOR_BGR2YUV_UYVY,
    "YU12": cv2.COLOR_BGR2YUV_I420,
    "YV12": cv2.COLOR_BGR2YUV_YV12,
}


@pytest.mark.parametrize("fourcc", [*PACKS, "BGR3", "RGB3"])
def test_raw_pictures_keep_their_colours(fourcc: str) -> None:
    picture = noisy(True)
    data = picture[..., ::-1] if fourcc == "RGB3" else picture
    data = cv2.cvtColor(picture, PACKS[fourcc]) if fourcc in PACKS else data
    flat = np.ascontiguousarray(data).reshape(-1)
    got = picture_of(flat, fourcc, SIZE, 0, colour=True)
    assert got is not None
    assert np.abs(got.astype(int) - picture).mean() < 6.0
    grey = picture_of(flat, fourcc, SIZE, 0, colour=False)
    assert grey is not None
    assert grey.shape == (48, 64)
    truth = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY).astype(float)
    assert np.corrcoef(grey.ravel(), truth.ravel())[0, 1] > 0.99
    assert picture_of(flat[:-100], fourcc, SIZE, 0, colour=False) is None


def test_lines_that_are_longer_than_their_pixels_are_cut() -> None:
    grey = noisy(False)
    padded = np.pad(grey, ((0, 0), (0, 16)), constant_values=7)
    got = picture_of(padded.reshape(-1), "GREY", SIZE, 80, colour=False)
    assert got is not None
    assert np.array_equal(got, grey)
    assert np.array_equal(
        picture_of(padded.reshape(-1)[:-16], "GREY", SIZE, 80, colour=False), grey
    )


@pytest.mark.parametrize(
    ("fourcc", "first"), [("RGGB", "rg"), ("BA81", "bg"), ("GBRG", "gb"), ("GRBG", "gr")]
)
def test_a_mosaic_s_colours_are_where_its_name_says(fourcc: str, first: str) -> None:
    """A red picture: red where the mosaic is red, dark elsewhere."""
    mosaic = np.zeros((48, 64), np.uint8)
    down, right = {"rg": (0, 0), "bg": (1, 1), "gb": (1, 0), "gr": (0, 1)}[first]
    mosaic[down::2, right::2] = 200
    got = picture_of(mosaic.reshape(-1), fourcc, SIZE, 0, colour=True)
    assert got is not None
    assert got[10:-10, 10:-10, 2].min() == 200
    assert got[10:-10, 10:-10, :2].max() == 0


@pytest.mark.parametrize("colour", [True, False])
def test_a_jpeg_keeps_its_size_and_a_damaged_one_is_none(colour: bool) -> None:
    picture = noisy(True)
    data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].reshape(-1)
    got = picture_of(data, "MJPG", SIZE, 0, colour=colour)
    assert got is not None
    assert got.shape == ((48, 64, 3) if colour else (48, 64))
    padded = np.concatenate([data, np.zeros(5000, np.uint8)])
    assert picture_of(padded, "MJPG", SIZE, 0, colour=colour) is not None, "filled up with zeros"
    for cut in range(0, len(data) - 2, 97):
        assert picture_of(data[:cut], "MJPG", SIZE, 0, colour=colour) is None
        zeroed = data.copy()
        zeroed[cut:] = 0
        assert picture_of(zeroed, "MJPG", SIZE, 0, colour=colour) is None
    assert picture_of(data, "MJPG", (48, 64), 0, colour=colour) is None, "another size than agreed"


@given(st.binary(max_size=400), st.sampled_from(ORDER), st.integers(0, 300))
def test_any_bytes_are_a_picture_of_the_size_or_none(data: bytes, fourcc: str, line: int) -> None:
    got = picture_of(np.frombuffer(data, np.uint8), fourcc, (8, 6), line, colour=True)
    assert got is None or got.shape[:2] == (6, 8)
