"""``clearway calibrate`` from the command line: pictures, points, a board on the floor."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from navigation.cli.main import run
from tests.support.drawn.boards import chessboard_patch, render
from tests.support.files.png_pictures import chunk, exif
from vision.calibration.calibration import Calibration, CalibrationError
from vision.calibration.calibration_file import load_calibration

SIZE = (480, 360)
CAMERA = [[460.0, 0.0, 242.0], [0.0, 461.0, 178.0], [0.0, 0.0, 1.0]]
LENS = [-0.2, 0.05, 0.0, 0.0, 0.0]
BOARD = ["--board", "chessboard", "--squares", "6x5", "--square-mm", "100"]
TURNS = [(0.4, 0.0, 0.1), (-0.4, 0.1, 0.5), (0.0, 0.45, -0.4), (0.1, -0.45, 1.0), (0.3, 0.3, 0.0)]


def seen_from(turn: tuple[float, float, float], height: float = 1.5) -> Calibration:
    """The floor's board seen from above its middle, the camera turned about it."""
    rotation = cv2.Rodrigues(np.array(turn))[0] @ np.diag([1.0, -1.0, -1.0])
    center = -rotation.T @ np.array([0.0, 0.0, height])
    pose = np.column_stack([rotation, -rotation @ center])
    return Calibration.from_camera(SIZE, CAMERA, LENS, pose)


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a command writes without being told where is not the project's."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("board")
    patch = chessboard_patch((6, 5), 0.1, (0.0, 0.0, 0.0))
    for i, turn in enumerate(TURNS):
        image = render(seen_from(turn), [patch], samples=2, rng=np.random.default_rng(i), noise=2.0)
        cv2.imwrite(str(folder / f"view{i}.png"), image)
    cv2.imwrite(str(folder / "view9.png"), np.full((360, 480), 128, np.uint8))
    return folder


def points_file(path: Path, calibration: Calibration, bad: int | None = None) -> Path:
    pixels = np.array(
        [(40, 40), (240, 30), (440, 50), (60, 320), (250, 330), (430, 300), (240, 180)]
    )
    places = calibration.arena_from_image(pixels)
    if bad is not None:
        places[bad] += (0.3, -0.2)
    rows = [f"{px},{py},{x:.6f},{y:.6f}" for (px, py), (x, y) in zip(pixels, places, strict=True)]
    path.write_text("px,py,x_m,y_m\n" + "\n".join(rows) + "\n")
    return path


def test_pictures_and_points_give_the_whole_calibration(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = seen_from((0.05, 0.08, 0.0))
    out = tmp_path / "c.yaml"
    points = points_file(tmp_path / "p.csv", truth, bad=4)
    arguments = ["--points", str(points), "-o", str(out)]
    assert run(["calibrate", str(pictures), *BOARD, *arguments]) == 0
    said = capsys.readouterr()
    assert "view9.png: left out: no chessboard" in said.err
    assert "line 6: left out" in said.err
    assert "over 6 of 7 points" in said.out
    assert "model: brown; on pictures left out by turns: brown 0." in said.out
    assert ", fisheye " in said.out
    found = load_calibration(out)
    assert found.camera_center_m is not None
    assert found.camera_center_m[2] == pytest.approx(1.5, abs=0.03)
    spots = np.random.default_rng(0).uniform((30, 30), (450, 330), (50, 2))
    error = found.arena_from_image(spots) - truth.arena_from_image(spots)
    assert np.linalg.norm(error, axis=1).mean() < 0.001


def test_a_board_on_the_floor_places_the_arena(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "c.yaml"
    floor = ["--floor-picture", str(pictures / "view0.png"), "--floor-at", "1.0,2.0,90"]
    assert run(["calibrate", str(pictures), *BOARD, *floor, "-o", str(out)]) == 0
    assert "over 30 of 30 points" in capsys.readouterr().out
    found, truth = load_calibration(out), seen_from(TURNS[0])
    spots = truth.image_from_arena([(-0.25, 0.2), (0.25, 0.2), (-0.25, -0.2)])
    first, along, down = found.arena_from_image(spots)
    if math.dist(first, (1.0, 2.0)) > 0.01:  # the board may begin at its other end
        pytest.fail(f"the first corner is at {first}")
    assert along == pytest.approx((1.0, 2.5), abs=0.003)
    assert down == pytest.approx((1.4, 2.0), abs=0.003)


def test_the_lens_of_an_old_calibration_serves_again(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first, second = tmp_path / "a.yaml", tmp_path / "b.yaml"
    old = points_file(tmp_path / "old.csv", seen_from((0.0, 0.0, 0.0)))
    new = points_file(tmp_path / "new.csv", seen_from((0.1, 0.0, 0.3), 2.0))
    assert run(["calibrate", str(pictures), *BOARD, "--points", str(old), "-o", str(first)]) == 0
    again = ["--lens", str(first), "--points", str(new), "-o", str(second)]
    assert run(["calibrate", *again]) == 0
    capsys.readouterr()
    a, b = load_calibration(first), load_calibration(second)
    assert np.array_equal(a.camera_matrix, b.camera_matrix)
    assert b.camera_center_m is not None
    assert b.camera_center_m[2] == pytest.approx(2.0, abs=0.04)


def test_points_alone_need_only_the_picture_s_size(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    points = points_file(tmp_path / "p.csv", Calibration.from_scale(0.005, SIZE))
    out = tmp_path / "c.yaml"
    assert run(["calibrate", "--points", str(points), "-o", str(out)]) == 2
    assert "--size" in capsys.readouterr().err
    assert run(["calibrate", "--points", str(points), "--size", "480x360", "-o", str(out)]) == 0
    assert load_calibration(out).metres_per_pixel == pytest.approx(0.005, rel=1e-4)


def test_a_lens_alone_is_saved_for_later_and_no_calibration_to_drive_by(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lens, out = tmp_path / "lens.yaml", tmp_path / "c.yaml"
    assert run(["calibrate", str(pictures), *BOARD, "-o", str(lens)]) == 0
    told = capsys.readouterr().out
    assert "over 5 pictures" in told
    assert f"written: {lens}, the lens alone" in told
    with pytest.raises(CalibrationError, match=r"lens\.yaml: holds a lens alone"):
        load_calibration(lens)
    truth = seen_from((0.05, 0.08, 0.0))
    points = points_file(tmp_path / "p.csv", truth)
    assert run(["calibrate", "--lens", str(lens), "--points", str(points), "-o", str(out)]) == 0
    found = load_calibration(out)
    assert found.camera_center_m is not None
    assert found.camera_center_m[2] == pytest.approx(1.5, abs=0.03)
    # the same as from the pictures at once
    both = tmp_path / "both.yaml"
    arguments = ["--points", str(points), "-o", str(both)]
    assert run(["calibrate", str(pictures), *BOARD, *arguments]) == 0
    # but for the order of sums, which is that of the threads
    again = load_calibration(both).camera_matrix
    np.testing.assert_allclose(again, found.camera_matrix, rtol=1e-6)


def test_a_board_larger_than_named_is_refused(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    board = ["--board", "chessboard", "--squares", "5x5", "--square-mm", "100"]
    out = tmp_path / "c.yaml"
    assert run(["calibrate", str(pictures), *board, "-o", str(out)]) != 0
    assert "the board has more corners than 5x5: is it 6x5?" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "give pictures"),
        (["nowhere.png"], "nowhere.png: cannot be read"),
        (["--points", "nowhere.csv", "--size", "10x10"], "nowhere.csv: cannot be read"),
        (["--points", "p.csv", "--size", "10"], "two whole numbers"),
        (["--camera", "/dev/video991"], "plugged in"),
        (["--live", "/dev/video991"], "plugged in"),
        (["a.png", "--live", "0"], "give pictures of a board, or --live"),
        (["a.png", "--page", "0"], "need --live"),
        (["--live", "0", "--limit-px", "0"], "--limit-px"),
        (["a.png", "--squares", "9"], "9x6"),
        (["a.png", "--square-mm", "0"], "square = 0.0 m"),
        (["a.png", "--lens", "b.yaml"], "--lens takes the place"),
        (["--floor-picture", "nowhere.png"], "cannot be read"),
    ],
)
def test_a_wrong_wish_is_one_sentence_and_code_2(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["calibrate", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert "Traceback" not in error


def test_the_real_chessboards_calibrate(
    real_data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = str(real_data / "calibration")
    board = ["--board", "chessboard", "--squares", "9x6", "--square-mm", "25"]
    assert run(["calibrate", folder, *board]) == 0
    said = capsys.readouterr().out
    assert float(said.split("lens: ")[1].split(" px")[0]) <= 0.20


def test_a_damaged_picture_is_named_and_left_out(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = sorted(pictures.glob("view[0-4].png"))
    damaged, missing = tmp_path / "cut.png", tmp_path / "missing.png"
    damaged.write_bytes(whole[0].read_bytes()[:2000])
    given = [*map(str, whole), str(damaged)]
    assert run(["calibrate", *given, *BOARD]) == 0
    said = capsys.readouterr()
    assert str(damaged) in said.err
    assert "left out" in said.err
    assert "over 5 pictures" in said.out
    assert run(["calibrate", *given, str(missing), *BOARD]) == 2
    assert str(missing) in capsys.readouterr().err
    assert run(["calibrate", str(damaged), *BOARD]) == 2


def test_a_picture_that_was_held_otherwise_is_taken_as_its_sensor_saw_it(
    pictures: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    whole = sorted(pictures.glob("view[0-4].png"))
    assert run(["calibrate", *map(str, whole), *BOARD]) == 0
    lens = capfd.readouterr().out
    held = tmp_path / "held.png"
    data = whole[0].read_bytes()
    held.write_bytes(data[:33] + chunk(b"eXIf", exif(3)) + data[33:])
    assert run(["calibrate", str(held), *map(str, whole[1:]), *BOARD]) == 0
    said = capfd.readouterr()
    assert said.out == lens
    assert f"{held}: its EXIF orientation, 3, is ignored" in said.err


def test_a_calibration_without_a_lens_is_no_lens(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A supposed focal length would put the camera at a wrong height without a word."""
    points = points_file(tmp_path / "p.csv", seen_from((0.05, 0.08, 0.0)))
    first, second = tmp_path / "a.yaml", tmp_path / "b.yaml"
    given = ["calibrate", "--points", str(points)]
    assert run([*given, "--size", "480x360", "-o", str(first)]) == 0
    capsys.readouterr()
    assert run([*given, "--lens", str(first), "-o", str(second)]) == 2
    assert "has no lens" in capsys.readouterr().err
    assert not second.exists()


@pytest.mark.parametrize("option", [["--dictionary", "NOPE"], ["--marker-mm", "12"]])
def test_markers_of_a_chessboard_are_refused(
    option: list[str], pictures: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["calibrate", str(pictures), *BOARD, *option]) == 2
    assert option[0] in capsys.readouterr().err


def test_a_surveyed_pixel_outside_the_picture_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    points = tmp_path / "p.csv"
    points.write_text("0,0,0,4\n639.5,0,6,4\n600,400,6,0\n0,400,0,0\n")
    out = ["--points", str(points), "-o", str(tmp_path / "c.yaml")]
    assert run(["calibrate", *out, "--size", "640x480"]) == 0
    capsys.readouterr()
    assert run(["calibrate", *out, "--size", "640x400"]) == 0
    assert run(["calibrate", *out, "--size", "640x399"]) == 2
    said = capsys.readouterr().err
    assert "line 3: the pixel (600, 400) must lie in the picture of 640x399" in said


def test_a_calibration_never_overwrites_what_it_is_made_from(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    points = points_file(tmp_path / "p.csv", seen_from((0.05, 0.08, 0.0)))
    before = points.read_bytes()
    assert run(["calibrate", "--points", str(points), "--size", "480x360", "-o", str(points)]) == 2
    assert f"--output {points}: would overwrite {points}, which is read" in capsys.readouterr().err
    assert points.read_bytes() == before
    made = tmp_path / "c.yaml"
    views = [str(p) for p in sorted(pictures.glob("view[0-4].png"))]
    given = ["--points", str(points), "-o", str(made)]
    assert run(["calibrate", *views, *BOARD, *given]) == 0
    assert run(["calibrate", "--lens", str(made), "--points", str(points), "-o", str(made)]) == 0
