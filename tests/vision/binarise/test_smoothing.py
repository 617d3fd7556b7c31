"""Smoothing row by row gives what OpenCV's smoothing of the whole picture gives."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from vision.binarise.binarise_kernels import sampled_histogram
from vision.binarise.grey_picture import (
    BINOMIAL,
    NO_SMOOTHING,
    WIDE_GAUSSIAN,
    GreyPicture,
    Smoothing,
    smoothing_of,
)

PICTURES = arrays.arrays(np.uint8, st.tuples(st.integers(1, 12), st.integers(1, 40)))
WHOLE = {BINOMIAL: lambda p: cv2.GaussianBlur(p, (5, 5), 0.0)}


@given(PICTURES, st.sampled_from([BINOMIAL]))
def test_a_smoothed_sample_is_a_sample_of_the_smoothed_picture(picture, smoothing) -> None:
    counts = GreyPicture(picture).counts_after(smoothing)
    np.testing.assert_array_equal(counts, sampled_histogram(WHOLE[smoothing](picture)))


@given(PICTURES, st.floats(-2.0, 257.0))
def test_a_smoothed_picture_is_compared_as_if_it_were_there(picture, level) -> None:
    height, width = picture.shape
    # no dot stands out of so much noise
    mask = GreyPicture(picture).mask_below(level, BINOMIAL, math.inf)
    np.testing.assert_array_equal(mask[1:-1, 1 : width + 1], WHOLE[BINOMIAL](picture) < level)
    assert int(mask.sum()) == int(mask[1 : height + 1, 1 : width + 1].sum())


def test_a_large_picture_is_sampled_where_a_smoothed_one_would_be() -> None:
    picture = np.random.default_rng(8).integers(0, 256, (733, 1201)).astype(np.uint8)
    for smoothing, whole in WHOLE.items():
        counts = GreyPicture(picture).counts_after(smoothing)
        np.testing.assert_array_equal(counts, sampled_histogram(whole(picture)))
        assert 20000 < counts.sum() < 45000


@pytest.mark.parametrize("smoothing", [NO_SMOOTHING, BINOMIAL, WIDE_GAUSSIAN])
@pytest.mark.parametrize("kind", [np.uint8, np.float32])
def test_a_smoothing_leaves_as_much_noise_as_it_says(smoothing: Smoothing, kind: type) -> None:
    rng = np.random.default_rng(2)
    noisy = np.clip(127.0 + rng.normal(0.0, 20.0, (400, 600)), 0.0, 255.0)
    grey_picture = GreyPicture(np.rint(noisy).astype(kind))
    assert abs(grey_picture.grey_after(smoothing).std() / 20.0 - smoothing.left) < 0.02


def test_the_more_noise_the_wider_is_the_smoothing() -> None:
    widths = [smoothing_of(noise).sigma_px for noise in (0.0, 5.0, 20.0, 40.0)]
    assert widths == [0.0, 1.0, 1.0, 2.0]
