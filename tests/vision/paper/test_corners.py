"""The paper's corner detector against its equations, written out."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vision.paper.corners import SUPPORT, THRESHOLD, find_corners, small_eigenvalues


def square(side: int) -> np.ndarray:
    edge = np.arange(side)
    top = np.stack([edge, np.zeros_like(edge)], axis=1)
    right = np.stack([np.full_like(edge, side), edge], axis=1)
    bottom = np.stack([side - edge, np.full_like(edge, side)], axis=1)
    left = np.stack([np.zeros_like(edge), side - edge], axis=1)
    return np.concatenate([top, right, bottom, left]).astype(np.int32)


@settings(max_examples=60, deadline=None)
@given(st.integers(15, 60), st.integers(2, 7), st.randoms(use_true_random=False))
def test_the_sliding_sums_are_the_covariance_of_equations_6_to_13(
    n: int, k: int, random: object
) -> None:
    rng = np.random.default_rng(n * 100 + k)
    contour = rng.integers(0, 2000, (n, 2)).astype(np.int32)
    values = small_eigenvalues(contour, np.array([0, n]), k)
    for i in range(n):
        support = contour[(i + np.arange(-k, k + 1)) % n].astype(float)
        expected = np.linalg.eigvalsh(np.cov(support.T, bias=True))[0]
        assert abs(values[i] - expected) <= 1e-6 * max(1.0, expected)


def test_a_square_has_its_four_corners() -> None:
    contour = square(40)
    corners = contour[find_corners(contour, np.array([0, len(contour)]))]
    assert sorted(map(tuple, corners.tolist())) == [(0, 0), (0, 40), (40, 0), (40, 40)]


def test_corners_are_at_least_k_apart_and_above_the_threshold() -> None:
    rng = np.random.default_rng(4)
    contour = np.cumsum(rng.integers(-1, 2, (300, 2)), axis=0).astype(np.int32)
    starts = np.array([0, len(contour)])
    chosen = np.flatnonzero(find_corners(contour, starts))
    gaps = np.diff(np.append(chosen, chosen[0] + len(contour)))
    assert gaps.min() >= SUPPORT
    assert small_eigenvalues(contour, starts)[chosen].min() > THRESHOLD


def test_a_contour_smaller_than_the_support_is_taken_whole() -> None:
    contour = np.array([[0, 0], [1, 0], [1, 1]], np.int32)
    assert np.isfinite(small_eigenvalues(contour, np.array([0, 3]))).all()
