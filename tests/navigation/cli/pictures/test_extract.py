"""`clearway extract` as a user sees it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest

from navigation.cli.main import run
from planner.formats.scene_io import read_scene_text


@pytest.fixture
def arena(tmp_path: Path) -> Path:
    picture = np.full((60, 90), 255, np.uint8)
    picture[10:30, 10:40] = 0
    cv2.circle(picture, (65, 35), 12, 0, -1)
    file = tmp_path / "arena.png"
    cv2.imwrite(str(file), picture)
    return file


def test_text_is_the_papers_records(arena: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["extract", str(arena)]) == 0
    scene = read_scene_text(capsys.readouterr().out)
    assert len(scene.objects) == 2
    assert scene.size == (90, 60)


def test_json_holds_what_the_design_names(arena: Path, tmp_path: Path) -> None:
    out = tmp_path / "scene.json"
    assert run(["extract", str(arena), "--format", "json", "-o", str(out), "--timings"]) == 0
    answer = json.loads(out.read_text())
    assert answer["schema"] == "clearway.scene/1"
    assert set(answer["timings_ms"]) == {"load", "binarise", "contours", "geometry", "total"}
    assert answer["counts"]["objects"] == 2
    assert {"method", "threshold", "polarity", "reason"} == set(answer["binarisation"])
    box = answer["objects"][0]["records"][0]
    assert box["type"] == "L"
    assert len(box["edges"]) == 4
    assert box["edges"][0]["kind"] == "segment"
    assert all("residual_px" in r for o in answer["objects"] for r in o["records"])


def test_the_overlay_is_a_picture(arena: Path, tmp_path: Path) -> None:
    out = tmp_path / "overlay.png"
    assert run(["extract", str(arena), "--paper", "--render", str(out)]) == 0
    height, width, _ = cv2.imread(str(out)).shape
    assert height >= 4 * 60
    assert width >= 4 * 90 + 200, "beside the enlarged picture is the legend"


@pytest.mark.parametrize("form", ["text", "json"])
def test_the_same_picture_gives_the_same_file(arena: Path, tmp_path: Path, form: str) -> None:
    one, other, timed = (tmp_path / name for name in ("one", "other", "timed"))
    for file in (one, other):
        assert run(["extract", str(arena), "--format", form, "-o", str(file)]) == 0
    assert run(["extract", str(arena), "--format", form, "-o", str(timed), "--timings"]) == 0
    assert one.read_bytes() == other.read_bytes()
    assert '"binarise"' in timed.read_text()
    assert '"binarise"' not in one.read_text()


def test_the_overlay_as_svg_shows_what_the_png_shows(arena: Path, tmp_path: Path) -> None:
    out = tmp_path / "overlay.svg"
    assert run(["extract", str(arena), "--render", str(out)]) == 0
    root = ElementTree.fromstring(out.read_text())
    ns = "{http://www.w3.org/2000/svg}"
    (image,) = root.iter(f"{ns}image")
    assert image.get("href", "").startswith("data:image/png;base64,")
    words = [text.text for text in root.iter(f"{ns}text")]
    for label in ("0 L", "1 C", "arena.png", "2 obstacles", "segments (4)", "circles (1)"):
        assert label in words
    # lines are where their pixels are: 4 screen pixels a pixel, centres at integers
    paths = [p for p in root.iter(f"{ns}path") if p.get("stroke") == "#d61c4e"]
    corners = np.array(re.findall(r"([\d.]+),([\d.]+)", paths[0].get("d", "")), dtype=float)
    wanted = 24 + 4 * (np.array([[9.5, 9.5], [39.5, 29.5]]) + 0.5)
    np.testing.assert_allclose([corners.min(axis=0), corners.max(axis=0)], wanted, atol=0.4)


def test_a_picture_in_which_nothing_was_found_is_a_warning_and_no_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "fog.png"
    cv2.imwrite(str(file), np.full((60, 90), 180, np.uint8))
    assert run(["extract", str(file), "--format", "json"]) == 0
    told = capsys.readouterr()
    warning = f"clearway: warning: {file}: no obstacle was found in the picture: no contrast"
    assert told.err.startswith(warning)
    assert told.err.count("\n") == 1
    (remark,) = json.loads(told.out)["remarks"]
    assert told.err == f"clearway: warning: {file}: {remark}\n"


def test_an_arena_is_answered_without_a_warning(
    arena: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["extract", str(arena)]) == 0
    told = capsys.readouterr()
    assert told.err == ""
    assert "ms" not in told.out
    assert run(["extract", str(arena), "--timings"]) == 0
    assert "#@ timings_ms" in capsys.readouterr().out


def test_the_answer_on_standard_output_is_the_file_and_the_same_again(
    arena: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["extract", str(arena), "-o", str(tmp_path / "a.txt")]) == 0
    capsys.readouterr()
    for more in ([], ["-o", "-"]):
        assert run(["extract", str(arena), *more]) == 0
        assert capsys.readouterr().out == (tmp_path / "a.txt").read_text()


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (None, "No such file"),
        (b"", "empty"),
        (b"no picture at all", "not a picture"),
        ("black", "no free space"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(
    content: bytes | str | None, word: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "bad.png"
    if content == "black":
        cv2.imwrite(str(file), np.zeros((20, 20), np.uint8))
    elif content is not None:
        file.write_bytes(content)
    assert run(["extract", str(file)]) == 2
    error = capsys.readouterr().err
    assert word in error
    assert str(file) in error
    assert error.count("\n") == 1
