"""A camera that was moved, placed anew by markers: truth is a camera whose place is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.scene import FloatArray
from tests.support.drawn.floor import (
    DICTIONARY,
    MARKER_M,
    PLACES,
    floor_texture,
    hanging,
    photograph,
    seen_corners,
)
from vision.calibrate.reanchor import MOST_RMS_PX, Anchor, reanchor
from vision.calibration.calibration import Calibration, CalibrationError
from vision.markers.reading import find_markers

BEFORE = hanging()
LENS = (-0.08, 0.02, 0.0004, -0.0003, 0.0)
FLOOR_GRID = np.stack(np.meshgrid(np.linspace(0, 2, 9), np.linspace(0, 1.5, 7)), -1).reshape(-1, 2)
ANCHORS = [Anchor(i, at, MARKER_M, 0.0) for i, at in PLACES.items()]
CENTRES = [Anchor(i, at, MARKER_M) for i, at in PLACES.items()]


def corners(
    camera: Calibration,
    moved: dict[int, tuple[float, float]] | None = None,
    rng: np.random.Generator | None = None,
) -> dict[int, FloatArray]:
    """What the camera sees, with noise of 0.05 px where ``rng`` is given."""
    places = {**PLACES, **(moved or {})}
    seen = {i: seen_corners(camera, at) for i, at in places.items()}
    if rng is None:
        return seen
    return {i: quad + rng.normal(0.0, 0.05, (4, 2)) for i, quad in seen.items()}


def error_m(found: Calibration, truth: Calibration) -> float:
    """The largest error on the floor."""
    there = found.arena_from_image(truth.image_from_arena(FLOOR_GRID))
    return float(np.hypot(*(there - FLOOR_GRID).T).max())


@given(
    st.floats(-4.0, 4.0), st.floats(-4.0, 4.0), st.floats(-20.0, 20.0),
    st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-0.2, 0.3), st.booleans(),
)  # fmt: skip
@settings(max_examples=20, deadline=None)
def test_without_noise_any_move_is_undone_to_the_bit_of_a_micrometre(
    about_x: float, about_y: float, turn: float, x: float, y: float, up: float, headings: bool
) -> None:
    truth = hanging((about_x, about_y), turn, (1.02 + x, 0.74 + y, 2.6 + up), LENS)
    before = hanging(distortion=LENS)
    found = reanchor(before, ANCHORS if headings else CENTRES, [corners(truth)])
    # a marker's diagonals bend a little through the lens: its centre is some hundredths off
    assert error_m(found.calibration, truth) < (1e-6 if headings else 5e-4)
    assert found.calibration.camera_center_m == pytest.approx(
        truth.camera_center_m, abs=1e-6 if headings else 3e-3
    )
    np.testing.assert_array_equal(found.calibration.camera_matrix, before.camera_matrix)
    np.testing.assert_array_equal(found.calibration.distortion, before.distortion)


@pytest.mark.parametrize(("anchors", "limit_m"), [(ANCHORS, 0.6e-3), (CENTRES, 1.0e-3)])
def test_noise_of_the_corners_is_less_than_a_millimetre_on_the_floor(
    anchors: list[Anchor], limit_m: float
) -> None:
    rng = np.random.default_rng(1)
    truth = hanging((2.0, -1.0), 3.0)
    errors = [
        error_m(reanchor(BEFORE, anchors, [corners(truth, None, rng)]).calibration, truth)
        for _ in range(25)
    ]
    assert np.percentile(errors, 95) < limit_m


def test_several_pictures_are_better_than_one() -> None:
    rng = np.random.default_rng(2)
    truth = hanging((2.0, -1.0), 3.0)
    many = [corners(truth, None, rng) for _ in range(12)]
    one = np.mean([error_m(reanchor(BEFORE, ANCHORS, [m]).calibration, truth) for m in many])
    assert error_m(reanchor(BEFORE, ANCHORS, many).calibration, truth) < 0.7 * one


def test_a_marker_that_was_kicked_is_named_and_left_out() -> None:
    truth = hanging((2.0, -1.0), 3.0)
    seen = corners(truth, {22: (2.02, 1.55)})
    found = reanchor(BEFORE, ANCHORS, [seen])
    assert [one.id for one in found.residuals if not one.used] == [22]
    assert error_m(found.calibration, truth) < 1e-6
    assert "floor marker 22: left out" in found.calibration.remarks[1]
    assert "anchored again by 4 floor markers" in found.calibration.remarks[0]


@pytest.mark.parametrize("anchors", [ANCHORS[:4], CENTRES[:4], CENTRES])
def test_markers_that_contradict_one_another_are_refused(anchors: list[Anchor]) -> None:
    moved = {20: (-0.02, -0.02), 22: (2.05, 1.50)}
    with pytest.raises(CalibrationError, match=r"contradict|fit no place"):
        reanchor(BEFORE, anchors, [corners(hanging((2.0, -1.0)), moved)])


def test_four_centres_with_one_moved_by_a_hand_are_refused() -> None:
    with pytest.raises(CalibrationError, match=f"at most {MOST_RMS_PX:g}"):
        reanchor(BEFORE, CENTRES[:4], [corners(hanging(), {21: (2.02, 0.02)})])


def test_too_few_markers_are_refused_with_those_that_are_missing() -> None:
    seen = corners(hanging())
    del seen[20], seen[23], seen[24]
    with pytest.raises(CalibrationError, match=r"2 floor markers .* not seen: 20, 23, 24"):
        reanchor(BEFORE, ANCHORS, [seen])
    with pytest.raises(CalibrationError, match="3 floor markers without a heading"):
        reanchor(BEFORE, CENTRES[:3], [corners(hanging())])


def test_a_calibration_without_a_lens_is_refused() -> None:
    with pytest.raises(CalibrationError, match="has no lens"):
        reanchor(Calibration.from_scale(0.004, (640, 480)), ANCHORS, [corners(hanging())])


def test_how_far_the_picture_moved_and_who_was_not_seen_is_said() -> None:
    seen = corners(hanging((1.31, -1.5)))
    del seen[21]
    found = reanchor(BEFORE, ANCHORS, [seen])
    assert found.missing == (21,)
    assert found.moved_px == pytest.approx(560 * math.tan(math.radians(0.31)), rel=0.2)


def test_markers_read_from_a_picture_place_the_camera_to_a_millimetre() -> None:
    truth = hanging((2.5, -0.5), 2.0)
    picture = photograph(truth, floor_texture(), np.random.default_rng(3))
    markers = find_markers(picture, DICTIONARY, calibration=BEFORE)
    found = reanchor(BEFORE, ANCHORS, [{one.id: one.corners_px for one in markers}])
    assert found.rms_px < 0.2
    assert error_m(BEFORE, truth) > 0.02
    assert error_m(found.calibration, truth) < 1.5e-3
