"""`clearway markers`: what a picture's markers are, as lines, as JSON and drawn."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.support.drawn.boards import marker_patch, render
from tests.support.pictures import Told, call
from vision.calibration.calibration import Calibration
from vision.calibration.calibration_file import save_calibration

FLAT = Calibration.from_scale(0.002, (640, 480))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A picture of two markers, an empty one, and a calibration."""
    seen = [
        marker_patch(cv2.aruco.DICT_4X4_50, 7, 0.12, (0.3, 0.3, 0.4)),
        marker_patch(cv2.aruco.DICT_6X6_250, 180, 0.14, (0.9, 0.25, 1.2)),
    ]
    cv2.imwrite(str(tmp_path / "two.png"), render(FLAT, seen))
    cv2.imwrite(str(tmp_path / "empty.png"), np.full((480, 640), 200, np.uint8))
    save_calibration(FLAT, tmp_path / "calibration.yaml")
    return tmp_path


def markers(folder: Path, *arguments: str) -> Told:
    with contextlib.chdir(folder):
        return call("markers", *arguments)


def test_json_has_ids_corners_and_poses(folder: Path) -> None:
    told = markers(folder, "two.png", "--calibration", "calibration.yaml", "--format", "json")
    assert told.code == 0, told.err
    body = json.loads(told.out)
    assert body["schema"] == "clearway.markers/1"
    assert body["size"] == [640, 480]
    assert [(m["dictionary"], m["id"]) for m in body["markers"]] == [
        ("DICT_4X4_50", 7),
        ("DICT_6X6_250", 180),
    ]
    assert all(m["refined"] and np.shape(m["corners"]) == (4, 2) for m in body["markers"])
    pose = body["markers"][0]["pose"]
    assert (pose["x_m"], pose["y_m"], pose["heading_rad"]) == pytest.approx(
        (0.3, 0.3, 0.4), abs=1e-3
    )


def test_a_line_a_marker_and_a_picture(folder: Path) -> None:
    told = markers(folder, "two.png", "--dictionary", "4X4_50", "--render", "seen.png")
    assert told.code == 0, told.err
    assert told.out.startswith("DICT_4X4_50 7: (")
    assert told.out.count("\n") == 1
    drawn, before = cv2.imread(str(folder / "seen.png")), cv2.imread(str(folder / "two.png"))
    assert drawn.shape == before.shape
    assert 100 < np.any(drawn != before, axis=2).sum() < 20_000


def test_no_marker_is_said_with_its_own_exit_code(folder: Path) -> None:
    told = markers(folder, "empty.png")
    assert (told.code, told.out) == (3, "")
    assert told.err == "clearway: empty.png: no marker found\n"


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("missing.png",), "missing.png"),
        (("calibration.yaml",), "calibration.yaml"),
        (("two.png", "--dictionary", "4X4_5O"), "did you mean DICT_4X4_50?"),
        (("two.png", "--dictionary", "no.yml"), "no.yml: not a dictionary of markers"),
        (("two.png", "--height-m", "0.1"), "is for --calibration only"),
        (("two.png", "--height-m", "nan"), "must be finite"),
        (("two.png", "--calibration", "two.png"), "two.png"),
        (("two.png", "--render", "two.png"), "two.png"),
    ],
)
def test_bad_input_is_one_sentence(arguments: tuple[str, ...], sentence: str, folder: Path) -> None:
    told = markers(folder, *arguments)
    assert told.code in (2, 78)
    assert sentence in told.err
    assert "Traceback" not in told.err
    assert told.out == ""
