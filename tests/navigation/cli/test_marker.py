"""``clearway marker``: what is printed is the marker asked for, at its true size."""

from __future__ import annotations

import math
import re
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

from navigation.cli.main import run
from vision.calibrate.board import BoardSpec, BoardView, find_board
from vision.markers.markers import find_markers

MM = 72.0 / 25.4
DOTS_PER_MM = 12.0


def rectangles_mm(pdf: bytes) -> tuple[NDArray[np.float64], tuple[float, float]]:
    """The drawing's rectangles (n, 4) in mm, y up, and the page's size: a reader of our own."""
    box = re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf)
    assert box is not None
    stream = re.search(rb"/Length (\d+) >>\nstream\n(.*?)\nendstream", pdf, re.DOTALL)
    assert stream is not None
    assert int(stream[1]) == len(stream[2])
    drawing = stream[2].split(b"\nf\n")[0]
    rows = re.findall(rb"([-\d.]+) ([-\d.]+) ([-\d.]+) ([-\d.]+) re", drawing)
    return np.array(rows, dtype=np.float64) / MM, (float(box[1]) / MM, float(box[2]) / MM)


def raster(rectangles: NDArray[np.float64], page: tuple[float, float]) -> NDArray[np.uint8]:
    """Dark where a rectangle covers a pixel's centre; the file's four decimals are forgiven."""
    picture = np.full([round(v * DOTS_PER_MM) for v in page[::-1]], 255, np.uint8)
    for x, y, w, h in rectangles:
        x0, x1 = (math.floor(v * DOTS_PER_MM + 0.501) for v in (x, x + w))
        y0, y1 = (math.floor((page[1] - v) * DOTS_PER_MM + 0.501) for v in (y + h, y))
        picture[y0:y1, x0:x1] = 0
    return picture


def png_dots_per_mm(data: bytes) -> float:
    place = data.index(b"pHYs")
    across, down, unit = struct.unpack(">IIB", data[place + 4 : place + 13])
    assert across == down
    assert unit == 1
    crc = struct.unpack(">I", data[place + 13 : place + 17])[0]
    assert crc == zlib.crc32(data[place : place + 13])
    return float(across) / 1000.0


@pytest.mark.parametrize(
    ("name", "marker_id", "size_mm"),
    [("DICT_4X4_50", 7, 80.0), ("DICT_APRILTAG_36h11", 100, 123.4), ("DICT_6X6_250", 0, 30.0)],
)
def test_both_files_show_the_marker_at_its_true_size(
    tmp_path: Path, name: str, marker_id: int, size_mm: float
) -> None:
    pdf, png = tmp_path / "m.pdf", tmp_path / "m.png"
    arguments = ["marker", str(marker_id), "--dictionary", name, "--size-mm", str(size_mm)]
    assert run([*arguments, "-o", str(pdf), "-o", str(png)]) == 0
    rectangles, page = rectangles_mm(pdf.read_bytes())
    assert page == pytest.approx((210.0, 297.0), abs=0.01)
    extent = (rectangles[:, :2] + rectangles[:, 2:]).max(axis=0) - rectangles[:, :2].min(axis=0)
    assert extent == pytest.approx((size_mm, size_mm), abs=0.001)
    assert [i for i, _ in find_markers(raster(rectangles, page), name)] == [marker_id]
    picture = cv2.imread(str(png), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    dark = np.flatnonzero((picture == 0).any(axis=0))
    across_mm = (dark[-1] - dark[0] + 1) / png_dots_per_mm(png.read_bytes())
    assert across_mm == pytest.approx(size_mm, rel=1e-4)
    margin = cv2.copyMakeBorder(picture, 40, 40, 40, 40, cv2.BORDER_CONSTANT, value=255)
    assert [i for i, _ in find_markers(margin.astype(np.uint8), name)] == [marker_id]


def test_a_pdf_s_cross_references_point_at_its_objects(tmp_path: Path) -> None:
    path = tmp_path / "m.pdf"
    assert run(["marker", "3", "-o", str(path)]) == 0
    data = path.read_bytes()
    start = re.search(rb"startxref\n(\d+)\n%%EOF\n$", data)
    assert start is not None
    assert data[int(start[1]) :].startswith(b"xref\n0 6\n")
    for number, place in enumerate(re.findall(rb"(\d{10}) 00000 n", data), start=1):
        assert data[int(place) :].startswith(b"%d 0 obj" % number)


@pytest.mark.parametrize(("board", "squares"), [("charuco", "5x7"), ("charuco", "6x8")])
def test_a_charuco_board_is_found_in_its_own_print(
    tmp_path: Path, board: str, squares: str
) -> None:
    path = tmp_path / "b.pdf"
    arguments = ["marker", "--board", board, "--squares", squares, "--square-mm", "25"]
    assert run([*arguments, "-o", str(path)]) == 0
    columns, rows = (int(v) for v in squares.split("x"))
    view = find_board(
        raster(*rectangles_mm(path.read_bytes())), BoardSpec("charuco", columns, rows, 0.025), "b"
    )
    assert isinstance(view, BoardView)
    assert len(view.corners_px) == (columns - 1) * (rows - 1)
    first = np.linalg.norm(view.corners_px[1] - view.corners_px[0]) / DOTS_PER_MM
    assert first == pytest.approx(25.0, abs=0.1)


def test_a_chessboard_is_found_in_its_own_print(tmp_path: Path) -> None:
    path = tmp_path / "b.png"
    arguments = ["marker", "--board", "chessboard", "--squares", "9x6", "--square-mm", "20"]
    assert run([*arguments, "-o", str(path)]) == 0
    picture = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    small = cv2.resize(picture, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    view = find_board(small.astype(np.uint8), BoardSpec("chessboard", 9, 6, 0.02), "b")
    assert isinstance(view, BoardView)


def test_the_first_hour_s_sheets_fit_on_their_paper(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    guide = Path(__file__).parents[3] / "docs" / "first_hour.md"
    commands = re.findall(
        r"^\.venv/bin/clearway (marker .*)$", guide.read_text(encoding="utf-8"), re.MULTILINE
    )
    assert len(commands) >= 2
    for command in commands:
        assert run(command.split()) == 0, command


def test_the_files_are_named_after_the_marker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["marker", "7"]) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "marker-4x4_50-7.pdf",
        "marker-4x4_50-7.png",
    ]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["50"], "ids 0 to 49"),
        (["7", "--size-mm", "300"], "does not fit on a4"),
        (["7", "--size-mm", "nan"], "1..1000"),
        (["7", "--dictionary", "DICT_4X4_5O"], "did you mean"),
        (["7", "-o", "m.svg"], ".pdf or .png"),
        (["7", "-o", "no/such/folder/m.pdf"], "cannot be written"),
        ([], "--board"),
        (["7", "--board", "charuco"], "not both"),
        (["--board", "charuco", "--squares", "5by7"], "9x6"),
        (["-3"], "3"),
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
    assert run(["marker", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert "Traceback" not in error


def arrows_mm(pdf: bytes) -> list[tuple[str, NDArray[np.float64]]]:
    """The arrows' words, and where each begins and points to, in mm, y up."""
    line = rb"0.8 w ([-\d.]+) ([-\d.]+) m [-\d. ]+ l S\n([-\d.]+) ([-\d.]+) m .*\n.*Td \((.*)\) Tj"
    return [
        (words.decode(), np.array(numbers, dtype=np.float64).reshape(2, 2) / MM)
        for *numbers, words in re.findall(line, pdf)
    ]


def test_a_printed_marker_has_an_arrow_forward_that_no_detector_sees(tmp_path: Path) -> None:
    file = tmp_path / "m.pdf"
    assert run(["marker", "7", "--size-mm", "90", "-o", str(file)]) == 0
    ((words, (begin, tip)),) = arrows_mm(file.read_bytes())
    assert words == "forward"
    dark, _ = rectangles_mm(file.read_bytes())
    right = (dark[:, 0] + dark[:, 2]).max()
    assert begin[0] > right + 90 / 6, "outside the white rim"
    assert tip[0] > begin[0]
    assert tip[1] == pytest.approx(begin[1])
    assert begin[1] == pytest.approx(0.5 * (dark[:, 1].min() + (dark[:, 1] + dark[:, 3]).max()))


@pytest.mark.parametrize("kind", ["chessboard", "charuco"])
def test_a_printed_board_shows_its_axes_from_its_first_corner(tmp_path: Path, kind: str) -> None:
    """Where the arrows meet is the first corner that is found on the print itself."""
    file = tmp_path / "b.pdf"
    squares = "7x4" if kind == "chessboard" else "7x5"
    board = ["--board", kind, "--squares", squares, "--square-mm", "20", "--paper", "a4"]
    assert run(["marker", *board, "-o", str(file)]) == 0
    data = file.read_bytes()
    arrows = dict(arrows_mm(data))
    meet = np.array([arrows["y"][0][0], arrows["x"][0][1]])
    assert arrows["x"][1][0] > arrows["x"][0][0], "x to the right"
    assert arrows["y"][1][1] > arrows["y"][0][1], "y up"
    assert b"first corner: where x and y meet" in data
    dark, page = rectangles_mm(data)
    columns, rows = map(int, squares.split("x"))
    kind_of = "charuco" if kind == "charuco" else "chessboard"
    view = find_board(raster(dark, page), BoardSpec(kind_of, columns, rows, 0.02), "print")
    assert isinstance(view, BoardView)
    (first,) = np.flatnonzero(np.hypot(*view.points_m.T) < 1e-9)
    x, y = (view.corners_px[first] + 0.5) / DOTS_PER_MM
    np.testing.assert_allclose(meet, (x, page[1] - y), atol=0.3)


def test_the_usual_marker_is_as_large_as_a_first_configuration_says(tmp_path: Path) -> None:
    page, config = tmp_path / "marker.pdf", tmp_path / "arena.yaml"
    assert run(["marker", "7", "-o", str(page)]) == 0
    assert run(["init", "--real", str(config)]) == 0
    size_m = yaml.safe_load(config.read_text())["robot"]["marker_size_m"]
    assert run(["marker", "7", "--size-mm", str(1000 * size_m), "-o", str(tmp_path / "o.pdf")]) == 0
    assert page.read_bytes() == (tmp_path / "o.pdf").read_bytes()
