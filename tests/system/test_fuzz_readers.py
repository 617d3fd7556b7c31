"""Damaged files for every reader: one clear sentence, never a traceback, a hang or a flood.

A few hundred of them; ``python -m tests.support.files.reader_fuzz --count 20000`` makes a campaign.
"""

from __future__ import annotations

import resource
import struct
from pathlib import Path

import numpy as np
import pytest

from planner.scene import SceneError
from tests.support.files.png_pictures import chunk, png
from tests.support.files.reader_fuzz import Reader, campaign, damaged, seeds, wrong_answer
from tests.support.pictures import call
from vision.calibration.calibration import CalibrationError
from vision.calibration.calibration_file import load_calibration
from vision.camera.camera import CameraError
from vision.camera.picture_files import read_picture
from vision.picture_error import PictureError

NO_WHOLE_NUMBERS = ("float.tif", ".pfm", ".hdr")
READERS = [
    *("source", "picture", "map", "scene", "movingai", "ros yaml", "survey", "calibration"),
    "recording",
]


@pytest.mark.parametrize("reader", READERS)
def test_a_damaged_file_is_read_or_refused_in_one_sentence(reader: str, tmp_path: Path) -> None:
    found = [f"{f.what}: {f.answer}" for f in campaign(150, 7, tmp_path, reader)]
    assert found == []


def test_the_files_before_the_damage_are_well(tmp_path: Path) -> None:
    for what, (reader, data) in seeds().items():
        assert wrong_answer(reader, data, tmp_path) == "", what
        if what.startswith("source ") and what.endswith(NO_WHOLE_NUMBERS):
            with pytest.raises(SceneError, match="must have 8 or 16 bits"):
                reader.read(tmp_path / reader.name)
        elif what == "picture float.tif":
            with pytest.raises(CameraError, match="not a picture that OpenCV can decode"):
                reader.read(tmp_path / reader.name)
        else:
            assert reader.read(tmp_path / reader.name) is not None


def test_the_campaign_would_see_a_traceback_and_a_sentence_over_two_lines(tmp_path: Path) -> None:
    def stumbles(path: Path) -> object:
        return {}[path]

    def babbles(path: Path) -> object:
        raise PictureError(f"{path}: bad\nand worse")

    assert "KeyError" in wrong_answer(Reader(stumbles, "x"), b"", tmp_path)
    assert "not one sentence" in wrong_answer(Reader(babbles, "x"), b"", tmp_path)


def test_the_same_seed_makes_the_same_damage() -> None:
    data = png(3, 8)
    first, second = (damaged(data, np.random.default_rng((1, 5))) for _ in range(2))
    assert first == second


@pytest.mark.parametrize("kind", ["png", "txt", "yaml", "map"])
def test_the_program_ends_with_code_2_and_one_sentence_for_what_cannot_be_read(
    kind: str, tmp_path: Path
) -> None:
    name = {"png": "source c2_8.png", "txt": "scene text", "yaml": "ros yaml", "map": "movingai"}
    reader, data = seeds()[name[kind]]
    for file, content in reader.beside:
        (tmp_path / file).write_bytes(content)
    refused = 0
    for number in range(25):
        path = tmp_path / reader.name
        path.write_bytes(damaged(data, np.random.default_rng((3, number))))
        told = call("plan", path, "--start", "3,3", "--goal", "12,3", "--radius", "0.2")
        assert told.code in (0, 2, 3), told
        assert "Traceback" not in told.err
        assert "unexpected" not in told.err, told.err
        if told.code == 2:
            refused += 1
            assert told.err.startswith("clearway: error: ")
            assert len(told.err.splitlines()) == 1, told.err
    assert refused > 5


# What campaigns have found.


def test_a_control_character_in_a_calibration_is_told_on_one_line(tmp_path: Path) -> None:
    path = tmp_path / "c.yaml"
    path.write_text("schema: clearway.calibration/1\nsize: [1,\x0b 2]\n")
    with pytest.raises(CalibrationError) as caught:
        load_calibration(path)
    assert len(str(caught.value).splitlines()) == 1


def test_brackets_thousands_deep_are_refused(tmp_path: Path) -> None:
    calibration = tmp_path / "c.yaml"
    calibration.write_text("[" * 3000)
    with pytest.raises(CalibrationError, match="nested too deeply"):
        load_calibration(calibration)
    told = call("check", calibration)
    assert told.code == 78
    assert "nested too deeply" in told.err


def test_a_picture_that_claims_gigabytes_costs_nothing(tmp_path: Path) -> None:
    ihdr = struct.pack(">IIBBBBB", 1 << 15, 1 << 15, 16, 6, 0, 0, 0)
    small = png(3, 8)
    path = tmp_path / "bomb.png"
    path.write_bytes(small[:8] + chunk(b"IHDR", ihdr) + small[33:])
    before_kib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    told = call("extract", path)
    assert told.code == 2
    assert "32768 x 32768 pixels: must be at most" in told.err
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before_kib < 100_000


@pytest.mark.parametrize("name", ["sparse.png", "sparse.txt", "sparse.map"])
def test_a_file_without_end_is_refused(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("planner.formats.map_files.MOST_BYTES", 1 << 20)
    monkeypatch.setattr("vision.camera.picture_files.MOST_BYTES", 1 << 20)
    path = tmp_path / name
    with path.open("wb") as file:
        file.truncate((1 << 20) + 1)
    told = call("plan", path, "--start", "3,3", "--goal", "12,3", "--radius", "0.2")
    assert told.code == 2
    assert "more than 1048576 bytes" in told.err
    with pytest.raises(CameraError, match="more than 1048576 bytes"):
        read_picture(path)


def test_a_map_with_cells_too_small_for_its_place_is_refused(tmp_path: Path) -> None:
    reader, data = seeds()["ros yaml"]
    tiny = data.replace(b"resolution: 0.05", b"resolution: 1e-320")
    assert wrong_answer(reader, tiny, tmp_path) == ""
    told = call("extract", tmp_path / "map.yaml")
    assert told.code == 2


def test_what_a_file_says_cannot_steer_the_terminal(tmp_path: Path) -> None:
    path = tmp_path / "grid.map"
    path.write_text("type octile\nheight \x1b[2J\nwidth 3\nmap\n...\n")
    told = call("plan", path, "--start", "0,0", "--goal", "1,0", "--radius", "0.2")
    assert told.code == 2
    assert "\\x1b[2J" in told.err
    assert "\x1b" not in told.err


@pytest.mark.parametrize("word", ["\\e[2J", "\\ufeff", "1\\u202e0"])
def test_what_a_calibration_says_cannot_steer_the_terminal(word: str, tmp_path: Path) -> None:
    data = seeds()["calibration"][1]
    for well in (b"0.47500000000000003", b"remarks: []"):
        new = f'"{word}"' if well.startswith(b"0") else f'remarks: ["{word}"]'
        path = tmp_path / "c.yaml"
        path.write_bytes(data.replace(well, new.encode()))
        try:
            said = "".join(load_calibration(path).remarks)
        except CalibrationError as error:
            said = str(error)
        assert "\\" in said
        assert said.isprintable()


def test_a_name_cannot_steer_the_terminal_either(tmp_path: Path) -> None:
    for path in (tmp_path / "\x1b[2J.png", tmp_path / "\u202e.png"):
        for data in (b"", b"none"):
            path.write_bytes(data)
            with pytest.raises(CameraError) as caught:
                read_picture(path)
            assert str(caught.value).isprintable()


def test_a_map_whose_picture_has_an_endless_name_is_refused_at_its_place(tmp_path: Path) -> None:
    reader, data = seeds()["ros yaml"]
    harmed = data.replace(b"map.pgm", b"m" + b"( " * 300)
    assert wrong_answer(reader, harmed, tmp_path) == ""
    with pytest.raises(SceneError, match=r"map.yaml:1:8: image: a name of .* characters: must be"):
        reader.read(tmp_path / "map.yaml")
