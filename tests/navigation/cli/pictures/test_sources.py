"""A SOURCE is judged by its content, and becomes a scene or one clear error."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

import planner
import vision
from navigation.cli.decoder_lines import caught_decoder_lines
from navigation.cli.main import run
from navigation.cli.options import Binarising
from navigation.cli.pictures.sources import hold_points, load_source, read_shades
from planner.formats.scene_io import read_scene_text
from planner.scene import Bounds, SceneError
from tests.support.drawn.render import outline_points
from tests.support.files.picture_formats import formats
from tests.support.files.png_pictures import chunk

FORMATS = dict(formats())


def arena(dark: int, light: int) -> np.ndarray:
    image = np.full((120, 160), light, dtype=np.uint8)
    cv2.rectangle(image, (40, 30), (80, 70), dark, -1)
    return image


@pytest.mark.parametrize("name", ["arena.png", "arena.bmp", "arena.pgm", "picture-without-suffix"])
def test_a_picture_is_known_by_its_content(tmp_path, name):
    path = tmp_path / name
    _, encoded = cv2.imencode(Path(name).suffix or ".png", arena(20, 230))
    path.write_bytes(encoded.tobytes())
    scene = load_source(path)
    assert scene.units == "px"
    assert scene.size == (160, 120)
    assert len(scene.objects) == 1
    assert {"load", "binarise", "contours", "geometry"} <= set(scene.timings_ms)


def test_polarity_says_which_side_is_obstacle(tmp_path):
    path = tmp_path / "arena.png"
    cv2.imwrite(str(path), arena(230, 20))
    light, either = Binarising("light"), Binarising("auto")
    assert load_source(path, light).objects == load_source(path, either).objects
    (obj,) = load_source(path, light).objects
    assert not obj.holes


def test_sixteen_bits_colour_and_transparency_are_read(tmp_path):
    grey = arena(20, 230)
    for number, image in enumerate(
        (grey.astype(np.uint16) * 257, cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR),
         cv2.cvtColor(grey, cv2.COLOR_GRAY2BGRA))
    ):  # fmt: skip
        path = tmp_path / f"{number}.png"
        cv2.imwrite(str(path), image)
        assert len(load_source(path).objects) == 1


def test_a_text_and_a_map_are_loaded_without_opencv(tmp_path):
    text = tmp_path / "scene"
    text.write_text("P (1,2)\n")
    assert load_source(text).units == "px"
    grid = tmp_path / "grid"
    grid.write_text("type octile\nheight 1\nwidth 2\nmap\n.@\n")
    assert load_source(grid).units == "cells"


@pytest.mark.parametrize("picture", ["arena", "photograph"])
def test_what_extract_writes_is_a_source_in_either_form(tmp_path, monkeypatch, capsys, picture):
    monkeypatch.chdir(tmp_path)
    source = str(planner.sample(picture))
    (tmp_path / "robots.csv").write_text(
        "start_x,start_y,goal_x,goal_y,radius\n40,40,600,440,12\n600,440,40,40,12\n"
    )
    answers = {}
    for form in ("text", "json"):
        assert run(["extract", source, "--format", form, "-o", f"scene.{form}"]) == 0
        capsys.readouterr()
        assert run(["roadmap", f"scene.{form}", "--radius", "12", "-o", f"{form}.json"]) == 0
        ends = ["--start", "40,40", "--goal", "600,440", "--radius", "12"]
        assert run(["plan", f"scene.{form}", *ends]) == 0
        assert run(["fleet", f"scene.{form}", "--robots", "robots.csv"]) == 0
        said = capsys.readouterr().out.replace(f"{form}.json", "graph.json")
        answers[form] = said, (tmp_path / f"{form}.json").read_text()
    assert answers["text"] == answers["json"]
    assert load_source(tmp_path / "scene.json").objects == load_source(Path(source)).objects


def test_what_is_no_scene_in_json_is_one_sentence_and_exit_code_2(tmp_path, capsys):
    wrong = tmp_path / "r.json"
    wrong.write_text('{"directed": false, "nodes": [], "edges": []}')
    ends = ["--start", "1,1", "--goal", "2,2", "--radius", "1"]
    assert run(["plan", str(wrong), *ends]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line == (
        f"clearway: error: {wrong}: schema None: must be 'clearway.scene/1', as clearway extract "
        "--format json writes it"
    )


def test_a_ros_map_may_have_a_png_picture(tmp_path):
    picture = np.full((4, 5, 4), 255, dtype=np.uint8)
    picture[1, 2, :3] = 0
    picture[2, 3, 3] = 10
    cv2.imwrite(str(tmp_path / "map.png"), picture)
    (tmp_path / "map.yaml").write_text("image: map.png\nresolution: 1\norigin: [0, 0, 0]\n")
    (obj,) = load_source(tmp_path / "map.yaml").objects
    assert len(obj.records[0].edges) == 8, "two cells that touch at a corner"


def test_shades_run_from_black_to_white_at_any_depth(tmp_path):
    for most, kind in ((255, np.uint8), (65535, np.uint16)):
        cv2.imwrite(str(tmp_path / "x.png"), np.array([[0, most]], dtype=kind))
        shade, transparent = read_shades(tmp_path / "x.png")
        np.testing.assert_array_equal(shade, [[0.0, 1.0]])
        assert not transparent.any()


@pytest.mark.parametrize(
    ("name", "data", "what"),
    [
        ("a.png", b"", "the file is empty"),
        ("a.jpg", b"text", "not a picture"),
        ("a.dat", b"\x89PNG\r\n\x1a\n garbage", "damaged picture"),
        ("a.dat", b"P5\n2 2\n255\n", "damaged picture"),
        ("a.dat", b"\xff\xfe\x00", "not a text file"),
    ],
)
def test_what_cannot_be_read_is_a_scene_error_with_the_files_name(tmp_path, name, data, what):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(SceneError, match=what) as caught:
        load_source(tmp_path / name)
    assert str(tmp_path / name) in str(caught.value)


def test_an_unusable_picture_names_its_file_too(tmp_path):
    cv2.imwrite(str(tmp_path / "black.png"), np.zeros((50, 50), dtype=np.uint8))
    with pytest.raises(SceneError, match=r"black\.png"):
        load_source(tmp_path / "black.png")


def test_derived_bounds_grow_and_given_bounds_do_not():
    derived = read_scene_text("P (0,0)")
    grown = hold_points(derived, [(10.0, 0.0), (0.0, -30.0)], room=2.0)
    assert grown.bounds == Bounds(-2.0, -32.0, 12.0, 2.0)
    assert not grown.bounds_given
    assert hold_points(derived, [(0.5, 0.5)], room=2.0) is derived
    given = derived.with_bounds(Bounds(-1, -1, 1, 1))
    assert hold_points(given, [(10.0, 0.0)], room=2.0) is given


def test_loading_is_timed_by_the_clock_that_is_given(tmp_path):
    (tmp_path / "scene").write_text("P (1,2)\n")
    ticks = iter([10.0, 10.25])
    scene = load_source(tmp_path / "scene", clock=lambda: next(ticks))
    assert scene.timings_ms["load"] == 250.0


OTHERWISE = ("float.tif", "pfm", "hdr", "cmyk.jpg", "ycck.jpg")
"""Refused, or drawn in blocks."""
UPRIGHT = [n for n in FORMATS if "turned" not in n and not n.endswith(OTHERWISE)]


@pytest.mark.parametrize("name", UPRIGHT)
def test_every_kind_of_file_shows_the_same_rectangle(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(FORMATS[name])
    (obj,) = load_source(path).objects
    (record,) = obj.records
    times = 4 if name.endswith("jp2") else 1
    corners = np.array([(8, 6), (19, 6), (19, 16), (8, 16)]) * times - 0.5
    points = outline_points(record)
    apart = np.linalg.norm(points[:, None] - corners[None], axis=2)
    assert apart.min(axis=0).max() < 0.6  # the poorest JPEG moves them so far
    assert points.min(axis=0) == pytest.approx(corners.min(axis=0), abs=0.5)
    assert points.max(axis=0) == pytest.approx(corners.max(axis=0), abs=0.5)


def corrupt_scan() -> bytes:
    """A JPEG whose scan breaks off in the middle, though its end is marked."""
    data = FORMATS["restarts.jpg"]
    scan = data.index(b"\xff\xda")
    return data[: scan + (len(data) - scan) // 2] + b"\xff\xd9"


def padded() -> bytes:
    """A JPEG with bytes of nobody's between its header and a marker, as some cameras write."""
    data = FORMATS["grey.jpg"]
    at = data.index(b"\xff\xdb")
    return data[:at] + bytes(9) + data[at:]


def no_width() -> bytes:
    header = struct.pack(">IIBBBBB", 0, 24, 8, 0, 0, 0, 0)
    data = FORMATS["c0_8.png"]
    return data[:8] + chunk(b"IHDR", header) + data[33:]


def test_what_a_decoder_complains_of_is_a_part_of_the_one_sentence(tmp_path, capfd, monkeypatch):
    monkeypatch.setenv("OPENCV_LOG_LEVEL", "SILENT")  # as the command line does
    for name, data, said in (
        ("a.png", no_width(), "(libpng error: Invalid IHDR data)"),
        ("a.jpg", corrupt_scan(), "a damaged picture: "),
    ):
        path = tmp_path / name
        path.write_bytes(data)
        with pytest.raises(SceneError) as caught:
            load_source(path)
        assert said in str(caught.value)
        assert "lib" in str(caught.value) or "Corrupt JPEG data" in str(caught.value)
        assert len(str(caught.value).splitlines()) == 1
    assert "lib" not in capfd.readouterr().err


def test_a_picture_with_bytes_of_nobody_s_is_read_with_a_remark(tmp_path, capfd, monkeypatch):
    monkeypatch.setenv("OPENCV_LOG_LEVEL", "SILENT")
    path = tmp_path / "padded.jpg"
    path.write_bytes(padded())
    scene = load_source(path)
    assert len(scene.objects) == 1
    assert any("may be damaged: Corrupt JPEG data: 9 extraneous" in a for a in scene.remarks)
    with pytest.raises(SceneError, match="may be damaged"):
        read_shades(path)
    assert "Corrupt" not in capfd.readouterr().err


@pytest.mark.parametrize("told", range(1, 9))
def test_a_picture_is_read_as_viewers_show_it(tmp_path, told):
    path = tmp_path / "held.jpg"
    path.write_bytes(FORMATS[f"turned_{told}.jpg"])
    shown = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    scene = load_source(path)
    assert scene.size == shown.shape[::-1]
    assert scene.objects == vision.extract(shown).objects
    assert any("EXIF orientation" in a for a in scene.remarks) == (told != 1)
    cells, _ = read_shades(path)
    assert cells.shape == (24, 32)


def test_the_lines_of_other_programs_come_through_where_opencv_s_do(tmp_path, capfd, monkeypatch):
    for level, seen in (("SILENT", False), ("INFO", True)):
        monkeypatch.setenv("OPENCV_LOG_LEVEL", level)
        with caught_decoder_lines() as said:
            os.write(2, b"libpng warning: of no weight\nlibpng error: bad \x1b[2J thing\n")
        assert said.lines == ("libpng error: bad [2J thing",)
        assert ("libpng warning: of no weight" in capfd.readouterr().err) == seen


def test_a_process_without_stderr_reads_pictures_too(tmp_path):
    path = tmp_path / "well.png"
    path.write_bytes(FORMATS["c0_8.png"])
    program = f"{Path(sys.executable).with_name('clearway')} extract {path} 2>&-"
    told = subprocess.run(program, shell=True, stdout=subprocess.PIPE, timeout=120)
    assert told.returncode == 0
    assert told.stdout.count(b"\nL ") == 1


def test_pictures_are_read_where_no_folder_can_be_written(tmp_path, monkeypatch):
    path = tmp_path / "well.png"
    path.write_bytes(FORMATS["c0_8.png"])
    for missing in ("memfd_create", "dup"):

        def fails(*_):
            raise OSError("no room")

        with monkeypatch.context() as patched:
            patched.setattr(os, missing, fails)
            assert len(load_source(path).objects) == 1
