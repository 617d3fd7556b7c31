"""Markers in one picture: of any dictionary, to hundredths of a pixel, and on the floor."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

import vision
from tests.support.drawn.boards import Patch, marker_patch, render
from vision.calibration.calibration import Calibration
from vision.markers.marker_search import MarkerError
from vision.markers.reading import find_markers, read_dictionary

FLAT = Calibration.from_scale(0.002, (640, 480))
PLACES = ((0.3, 0.3, 0.4), (0.8, 0.6, -2.0), (0.9, 0.25, 1.2))
SIZES = (0.12, 0.10, 0.14)
MARKERS = (("DICT_4X4_50", 7), ("DICT_APRILTAG_36H11", 5), ("DICT_6X6_250", 180))


def patches() -> list[Patch]:
    return [
        marker_patch(getattr(cv2.aruco, name), marker_id, size, place)
        for (name, marker_id), size, place in zip(MARKERS, SIZES, PLACES, strict=True)
    ]


def true_corners(size_m: float, place: tuple[float, float, float]) -> np.ndarray:
    """Clockwise on the screen from the upper left one of the upright marker, in pixels."""
    x, y, turn = place
    corners = np.array([(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)]) * size_m
    c, s = math.cos(turn), math.sin(turn)
    return FLAT.image_from_arena(corners @ np.array([(c, s), (-s, c)]) + (x, y))


def test_markers_of_all_dictionaries_are_found_and_named() -> None:
    picture = render(FLAT, patches(), rng=np.random.default_rng(0), noise=3.0)
    before = picture.copy()
    found = find_markers(picture)
    assert {(m.dictionary, m.id) for m in found} == set(MARKERS)
    assert all(m.agreement == 1.0 and m.remark == "" and m.pose is None for m in found)
    assert np.array_equal(picture, before)


@pytest.mark.parametrize("calibration", [None, FLAT])
def test_corners_are_where_they_were_painted(calibration: Calibration | None) -> None:
    picture = render(FLAT, patches())
    by_id = {m.id: m for m in find_markers(picture, calibration=calibration)}
    for (_, marker_id), size, place in zip(MARKERS, SIZES, PLACES, strict=True):
        off = np.abs(by_id[marker_id].corners_px - true_corners(size, place)).max()
        assert off < (0.02 if calibration else 0.05), marker_id


def test_poses_are_those_of_the_floor() -> None:
    picture = render(FLAT, patches(), rng=np.random.default_rng(1), noise=2.0)
    by_id = {m.id: m for m in find_markers(picture, calibration=FLAT)}
    for (_, marker_id), size, place in zip(MARKERS, SIZES, PLACES, strict=True):
        marker = by_id[marker_id]
        assert marker.pose is not None
        assert marker.pose == pytest.approx(place, abs=2e-3)
        assert math.dist(marker.pose[:2], place[:2]) < 5e-5
        assert marker.size_m == pytest.approx(size, rel=1e-3)


def test_a_covered_corner_is_said_and_not_invented() -> None:
    picture = render(FLAT, patches()[:1])
    x, y = np.rint(true_corners(SIZES[0], PLACES[0])[0]).astype(int)
    picture[y - 12 : y + 12, x - 12 : x + 12] = 200
    found = find_markers(picture, "DICT_4X4_50")
    assert all(m.remark for m in found)


@pytest.mark.parametrize("name", ["4X4_50", "dict_4x4_50"])
def test_one_dictionary_goes_by_any_spelling(name: str) -> None:
    (marker,) = find_markers(render(FLAT, patches()), name)
    assert (marker.dictionary, marker.id) == MARKERS[0]


def test_noise_and_stripes_hold_no_markers() -> None:
    rng = np.random.default_rng(3)
    for picture in (
        rng.integers(0, 256, (480, 640), dtype=np.uint8),
        np.kron(rng.integers(0, 2, (30, 40)), np.ones((16, 16))).astype(np.uint8) * 255,
    ):
        assert find_markers(picture) == ()


def test_a_dictionary_of_ones_own(tmp_path: Path) -> None:
    book = cv2.aruco.extendDictionary(5, 5)
    storage = cv2.FileStorage(str(tmp_path / "own.yml"), cv2.FILE_STORAGE_WRITE)
    book.writeDictionary(storage)
    storage.release()
    assert len(read_dictionary(tmp_path / "own.yml").bytesList) == 5
    picture = np.full((200, 200), 230, np.uint8)
    picture[50:150, 50:150] = cv2.aruco.generateImageMarker(book, 3, 98 + 2)
    (marker,) = find_markers(picture, tmp_path / "own.yml")
    assert (marker.dictionary, marker.id) == ("own.yml", 3)
    corners = [(49.5, 49.5), (149.5, 49.5), (149.5, 149.5), (49.5, 149.5)]
    assert np.abs(marker.corners_px - corners).max() < 0.1


@pytest.mark.parametrize("content", ["", "%YAML:1.0\n---\na: 1\n", "{", "nmarkers: 3"])
def test_a_file_that_is_no_dictionary_is_refused(content: str, tmp_path: Path) -> None:
    (tmp_path / "bad.yml").write_text(content)
    with pytest.raises(MarkerError, match=r"bad\.yml: not a dictionary of markers"):
        find_markers(np.zeros((10, 10), np.uint8), tmp_path / "bad.yml")


def test_what_is_no_picture_is_refused() -> None:
    with pytest.raises(MarkerError, match=r"must be \(h, w\) grey"):
        vision.find_markers(np.zeros((10, 10)))
    with pytest.raises(MarkerError, match=r"10x10, the calibration's 640x480"):
        vision.find_markers(np.zeros((10, 10), np.uint8), calibration=FLAT)
    with pytest.raises(MarkerError, match=r"did you mean DICT_4X4_50\?"):
        vision.find_markers(np.zeros((10, 10), np.uint8), "4X4_5O")
