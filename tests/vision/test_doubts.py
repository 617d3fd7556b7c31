"""A picture in which nothing was seen, or hardly an arena, says so; an arena does not."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from planner.formats.scene_io import read_scene_text, write_scene_text
from planner.scene import Bounds, CircleRecord, Scene, SceneObject
from tests.support.pictures import box_and_disc
from vision import doubts_about, extract
from vision.doubts import MOST_RECORDS


def clouds() -> np.ndarray:
    """Perlin's kind of noise: octaves of smooth noise, nowhere an edge."""
    rng = np.random.default_rng(5)
    grey = np.zeros((240, 320))
    for octave in range(1, 6):
        cells = rng.standard_normal((2**octave + 2, 2**octave + 2))
        grey += cv2.resize(cells, (320, 240), interpolation=cv2.INTER_CUBIC) * 0.55**octave
    return np.clip(128.0 + 60.0 * grey / np.abs(grey).max(), 0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    ("picture", "why"),
    [(np.full((240, 320), 215, np.uint8), "no contrast"), (clouds(), "no edges")],
)
def test_a_picture_without_a_border_says_that_nothing_was_found(
    picture: np.ndarray, why: str
) -> None:
    scene = extract(picture)
    assert scene.objects == ()
    (doubt,) = doubts_about(scene)
    assert doubt.startswith(f"no obstacle was found in the picture: {why}")
    assert scene.remarks[0] == doubt


def test_an_arena_is_not_in_doubt() -> None:
    scene = extract(box_and_disc())
    assert doubts_about(scene) == ()
    assert scene.remarks == ()


def test_a_picture_of_more_records_than_any_arena_says_how_many() -> None:
    picture = np.full((400, 600), 215, np.uint8)
    for y in range(6, 396, 12):
        for x in range(6, 596, 12):
            picture[y : y + 5, x : x + 5] = 40
    scene = extract(picture)
    assert len(scene.objects) == 33 * 50 > MOST_RECORDS
    (doubt,) = doubts_about(scene)
    assert doubt.startswith("1650 records were found, more than 1000")
    assert doubt in scene.remarks


def test_a_scene_that_was_written_and_read_is_in_the_same_doubt() -> None:
    scene = extract(np.full((240, 320), 215, np.uint8))
    assert doubts_about(read_scene_text(write_scene_text(scene))) == doubts_about(scene) != ()


def test_scenes_of_no_picture_are_not_in_doubt() -> None:
    """An empty map is one that somebody drew empty; a large one has as many records as it has."""
    empty = Scene("m", Bounds(0.0, 0.0, 1.0, 1.0), ())
    disc = SceneObject(0, (CircleRecord((0.5, 0.5), 0.1),))
    full = replace(empty, objects=(disc,) * (MOST_RECORDS + 1))
    assert doubts_about(empty) == doubts_about(full) == ()
