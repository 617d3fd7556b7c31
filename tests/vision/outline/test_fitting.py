"""Edge counts in pictures of black and white only: a staircase is not geometry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.scene import Arc, PolygonRecord
from vision import extract
from vision.calibration.calibration import Calibration
from vision.outline import fitting

Y, X = np.mgrid[0:240, 0:240].astype(float)
MIDDLE = 120.0


def picture(inside: np.ndarray) -> np.ndarray:
    """Black where true, without grey."""
    return np.where(inside, 0, 255).astype(np.uint8)


def test_a_run_needs_no_kernels_that_separate_pixels(monkeypatch: pytest.MonkeyPatch) -> None:
    fitted: list[str] = []
    for name in ("fit_borders", "fit_separated_borders"):
        fit = getattr(fitting, name)
        monkeypatch.setattr(fitting, name, lambda *a, f=fit, n=name: fitted.append(n) or f(*a))
    disc = picture(np.hypot(X - MIDDLE, Y - MIDDLE) <= 50.0)
    extract(disc, calibration=Calibration.from_scale(0.01, (240, 240)))
    assert fitted == ["fit_borders"]
    extract(disc)
    assert fitted == ["fit_borders", "fit_separated_borders"]


def turned(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """The pixels' coordinates along and across a direction, from the middle."""
    x, y = X - MIDDLE, Y - MIDDLE
    return x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)


def edge_counts(image: np.ndarray) -> tuple[int, int]:
    """Lines and arcs of a picture's only object."""
    (only,) = extract(image).objects
    (record,) = only.records
    assert isinstance(record, PolygonRecord)
    arcs = sum(isinstance(edge, Arc) for edge in record.edges)
    return len(record.edges) - arcs, arcs


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.floats(0.0, 6.28), st.floats(40.0, 100.0))
def test_a_half_disc_without_grey_is_one_line_and_one_arc(angle: float, radius: float) -> None:
    along, across = turned(angle)
    inside = (np.hypot(along, across) <= radius) & (across >= 0.0)
    assert edge_counts(picture(inside)) == (1, 1)


@pytest.mark.parametrize("radius", [20.0, 30.0, 45.0])
@pytest.mark.parametrize("half", [30.0, 50.0])
def test_an_upright_stadium_without_grey_is_two_lines_and_two_arcs(
    radius: float, half: float
) -> None:
    along, across = turned(0.0)
    inside = np.hypot(np.maximum(np.abs(along) - half, 0.0), across) <= radius
    assert edge_counts(picture(inside)) == (2, 2)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.floats(0.0, 6.28), st.floats(20.0, 45.0))
def test_a_stadium_without_grey_breaks_into_few_edges(angle: float, radius: float) -> None:
    along, across = turned(angle)
    inside = np.hypot(np.maximum(np.abs(along) - 50.0, 0.0), across) <= radius
    lines, arcs = edge_counts(picture(inside))
    assert arcs >= 2
    assert lines + arcs <= 6


@pytest.mark.parametrize("radius", [15.0, 25.0, 40.0])
def test_a_rounded_square_without_grey_is_four_lines_and_four_arcs(radius: float) -> None:
    along, across = turned(0.0)
    beyond = np.hypot(
        np.maximum(np.abs(along) - 80.0 + radius, 0.0),
        np.maximum(np.abs(across) - 80.0 + radius, 0.0),
    )
    assert edge_counts(picture(beyond <= radius)) == (4, 4)
