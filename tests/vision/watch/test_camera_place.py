"""A camera that was moved is told from a marker that was kicked, from a hand, and from noise."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from tests.support.drawn.floor import (
    BOUNDS,
    DICTIONARY,
    PLACES,
    floor_texture,
    hanging,
    noisy,
    photograph,
)
from vision.calibration.calibration import Calibration
from vision.camera.camera import Image
from vision.watch.camera_place import CameraPlace, FloorMarker, PlaceReport, PlaceSettings

NO_DISCS = np.empty((0, 3))
CAMERA = hanging()
TILT_DEG = 0.31
"""3 px with a focal length of 560 px."""
KNOCKED = hanging((1.0 + TILT_DEG, -1.5))
RATE_HZ = 30.0
ALL_WELL = PlaceReport(moved_px=pytest.approx(0.0, abs=0.3))


class Watched:
    """A place that is watched, and time that passes."""

    def __init__(
        self,
        places: Mapping[int, tuple[float, float] | None] | None = None,
        calibration: Calibration = CAMERA,
        limit_px: float = 2.0,
    ) -> None:
        places = PLACES if places is None else places
        markers = tuple(FloorMarker(i, at) for i, at in places.items())
        settings = PlaceSettings(BOUNDS, markers, DICTIONARY, limit_px)
        self.place = CameraPlace(calibration, settings, 10.0)
        self.now_s = 12.0
        self.rng = np.random.default_rng(7)

    def see(
        self, camera: Calibration, floor: Image, seconds: float, discs: np.ndarray = NO_DISCS
    ) -> PlaceReport:
        """What is said at the end; pictures differ in their noise."""
        clean = photograph(camera, floor)
        pictures = [noisy(clean, self.rng) for _ in range(4)]
        for i in range(round(seconds * RATE_HZ)):
            self.now_s += 1.0 / RATE_HZ
            report = self.place.look(pictures[i % 4], discs, self.now_s, may_learn=True)
        return report


MARKED = floor_texture()
PLAIN = floor_texture({})


@pytest.mark.parametrize(
    ("floor", "places"),
    [(MARKED, PLACES), (MARKED, dict.fromkeys(PLACES)), (PLAIN, {})],
    ids=["surveyed markers", "markers", "corners"],
)
def test_three_pixels_are_noticed_within_a_second_and_over_when_the_camera_is_back(
    floor: Image, places: Mapping[int, tuple[float, float] | None]
) -> None:
    watched = Watched(places)
    assert watched.see(CAMERA, floor, 1.5) == ALL_WELL
    report = watched.see(KNOCKED, floor, 1.0)
    assert report.moved_px == pytest.approx(3.0, abs=0.4)
    count = len(watched.place.points)
    assert f"the camera has moved: {count} of {count} fixed points (" in report.moved
    assert "since 3.5 s into the run" in report.moved
    assert "are seen 3." in report.moved or "are seen 2.9" in report.moved
    assert not report.lost
    again = watched.see(KNOCKED, floor, 1.0)
    assert again.moved == report.moved, "the same sentence while nothing is new"
    assert watched.see(CAMERA, floor, 1.0).moved == ""


def test_a_marker_that_is_kicked_away_is_not_a_knocked_camera() -> None:
    watched = Watched()
    watched.see(CAMERA, MARKED, 1.5)
    kicked = floor_texture({**PLACES, 22: (2.07, 1.57)})
    report = watched.see(CAMERA, kicked, 1.5)
    assert (report.moved, report.lost) == ("", "")
    (remark,) = report.remarks
    assert remark.startswith("floor marker 22 was moved by 9")
    assert remark.endswith("the camera has not moved")
    both = watched.see(hanging((1.0 + 2 * TILT_DEG, -1.5)), kicked, 1.0)
    assert "the camera has moved" in both.moved


def test_a_marker_that_is_covered_is_said_and_a_hand_over_most_is_no_knock() -> None:
    watched = Watched()
    watched.see(CAMERA, MARKED, 1.5)
    one_less = floor_texture({i: at for i, at in PLACES.items() if i != 21})
    (remark,) = watched.see(CAMERA, one_less, 1.0).remarks
    assert remark.startswith("floor marker 21 is not seen")
    hand = floor_texture({20: PLACES[20]})
    report = watched.see(CAMERA, hand, 1.0)
    assert report.moved == ""
    assert "4 of 5 fixed points are not seen where they were" in report.lost
    assert watched.see(CAMERA, MARKED, 1.0) == ALL_WELL


def test_what_robots_cover_says_nothing() -> None:
    watched = Watched()
    watched.see(CAMERA, MARKED, 1.5)
    discs = np.array([[*CAMERA.image_from_arena([PLACES[i]])[0], 60.0] for i in (20, 21, 22)])
    hidden = floor_texture({23: PLACES[23], 24: PLACES[24]})
    report = watched.see(CAMERA, hidden, 2.0, discs)
    assert (report.moved, report.lost, report.remarks) == ("", "", ())


@pytest.mark.parametrize("tilt_deg", [0.5, 2.5])
def test_a_camera_that_was_moved_before_the_run_is_noticed_by_surveyed_markers(
    tilt_deg: float,
) -> None:
    watched = Watched()
    elsewhere = hanging((1.0 + tilt_deg, -1.5), at_m=(1.02 + 0.04 * tilt_deg, 0.74, 2.6))
    report = watched.see(elsewhere, MARKED, 0.1)
    assert "since before the run" in report.moved
    assert watched.see(elsewhere, MARKED, 3.0).moved == report.moved
    assert watched.see(CAMERA, MARKED, 4.0) == PlaceReport(
        moved_px=pytest.approx(0.0, abs=0.6), remarks=()
    )


def test_too_few_surveyed_markers_tell_nothing_and_hold_until_one_is_in_its_place() -> None:
    watched = Watched()
    aside = hanging((9.0, -1.5))
    report = watched.see(aside, MARKED, 1.0)
    assert report.lost
    assert "of 5 floor markers are seen" in report.lost
    assert watched.see(CAMERA, floor_texture({}), 3.0).lost.startswith("0 of 5 floor markers")
    one = floor_texture({23: PLACES[23]})
    assert watched.see(CAMERA, one, 4.0).lost == ""


def test_a_far_knock_holds_and_is_measured_by_surveyed_markers() -> None:
    watched = Watched()
    watched.see(CAMERA, MARKED, 1.5)
    elsewhere = hanging((1.0, -1.5), turn_deg=8.0)
    soon = watched.see(elsewhere, MARKED, 1.0)
    assert soon.moved or soon.lost
    report = watched.see(elsewhere, MARKED, 4.0)
    assert "the camera has moved: " in report.moved
    assert report.moved_px is not None
    assert report.moved_px > 20.0
    assert not watched.see(CAMERA, MARKED, 4.0).moved


def test_too_few_points_are_said_and_so_is_a_marker_that_is_not_there() -> None:
    empty = floor_texture({}, ())
    watched = Watched({20: None})
    report = watched.see(CAMERA, empty, 0.2)
    assert "a knocked camera would not be noticed" in report.remarks[0]
    assert "floor marker 20: not seen steadily" in report.remarks[1]


def test_a_limit_of_zero_watches_nothing() -> None:
    watched = Watched(limit_px=0.0)
    assert watched.see(CAMERA, MARKED, 0.1) == watched.see(KNOCKED, MARKED, 0.1) == PlaceReport()


def test_a_point_that_trembles_is_left_out() -> None:
    """One marker hangs from a thread."""
    watched = Watched()
    swaying = [floor_texture({**PLACES, 24: (1.0 + dx, 1.62)}) for dx in (0.0, 0.012)]
    pictures = [photograph(CAMERA, floor, watched.rng) for floor in swaying]
    for i in range(60):
        watched.now_s += 1.0 / RATE_HZ
        report = watched.place.look(pictures[i // 2 % 2], NO_DISCS, watched.now_s, may_learn=True)
    assert [p.marker_id for p in watched.place.points] == [20, 21, 22, 23]
    assert report.remarks == (
        "floor marker 24: not seen steadily when the camera's place was learned, and not watched",
    )
