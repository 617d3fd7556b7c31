"""Files that cannot be read or hold no usable picture are refused by name."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.support.pictures import Told, blank, call, save
from tests.system.bad_input.refusals import JOURNEY, assert_no_path, assert_refused

# Files.


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("missing.png", ["No such file"]),
        ("folder.png", ["directory"]),
        ("empty.png", ["empty"]),
        ("head_only.png", ["picture"]),
        ("half.png", ["picture"]),
        ("words.png", ["not a picture"]),
        ("noise.png", ["not a picture"]),
        ("black.png", ["no free space", "200 x 200"]),
        ("one_black.png", ["no free space"]),
    ],
)
def test_a_file_that_holds_no_usable_picture_is_refused_by_name(
    folder: Path, name: str, words: list[str]
) -> None:
    file = folder / name
    assert_refused(call("extract", file), 2, str(file), *words)
    assert_refused(call("plan", file, *JOURNEY), 2, str(file), *words)
    made = folder / "never.json"
    assert_refused(call("roadmap", file, "--radius", "9", "-o", made), 2, str(file), *words)
    assert not made.exists()


@pytest.mark.parametrize(
    ("name", "word"),
    [("words.txt", "words.txt:1"), ("short.map", "short.map"), ("no_image.yaml", "gone.pgm")],
)
def test_a_scene_or_map_that_cannot_be_read_is_refused_by_name(
    folder: Path, name: str, word: str
) -> None:
    assert_refused(call("plan", folder / name, *JOURNEY), 2, word)


def test_a_file_without_permission_is_refused(folder: Path) -> None:
    if os.geteuid() == 0:
        file = Path("/proc/self/mem")  # root may read any file but this one's first byte
        assert_refused(call("extract", file), 2, str(file))
        return
    file = folder / "secret.png"
    file.write_bytes(b"x")
    file.chmod(0)
    assert_refused(call("extract", file), 2, str(file), "ermission")


def test_an_all_white_picture_is_an_empty_arena(folder: Path) -> None:
    file = save(folder, "white.png", blank(640, 480, 255))
    assert call("extract", file).code == 0
    told = call("plan", file, *JOURNEY)
    assert told.code == 0
    assert without_warning(told, file).err == ""


def without_warning(told: Told, file: Path) -> Told:
    """The first line on stderr warns that the picture shows nothing; what else was said."""
    warning, rest = told.err.split("\n", 1)
    assert warning.startswith(f"clearway: warning: {file}: no obstacle was found in the picture")
    return told._replace(err=rest)


def test_a_picture_of_one_white_pixel_has_no_room(folder: Path) -> None:
    file = save(folder, "one.png", blank(1, 1, 255))
    assert call("extract", file).code == 0
    told = call("plan", file, "--start", "0,0", "--goal", "0,0", "--radius", "9")
    assert_no_path(without_warning(told, file), "start")
