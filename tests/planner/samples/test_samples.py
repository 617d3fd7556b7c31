"""The samples that come with Clearway are small, drawn by a command, and of use."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

import planner
import vision
from benchmarks.figures import samples
from planner.samples.sample import SAMPLES, sample_files

PICTURES = sorted(set(SAMPLES) - {"rooms"})
FILES = sorted(file for files in SAMPLES.values() for file in files)


def test_every_file_in_the_folder_is_one_of_a_sample() -> None:
    folder = planner.sample("arena").parent
    there = (file.name for file in folder.iterdir() if file.suffix not in (".py", ""))
    assert sorted(there) == FILES


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_a_sample_is_smaller_than_100_kilobytes(name: str) -> None:
    assert all(0 < file.stat().st_size < 100_000 for file in sample_files(name))


@pytest.mark.parametrize("name", FILES)
def test_the_command_draws_the_files_as_they_are(name: str, tmp_path: Path) -> None:
    samples.draw(tmp_path)
    kept = samples.FOLDER / name
    if kept.suffix == ".yaml":
        assert (tmp_path / name).read_bytes() == kept.read_bytes()
        return
    drawn = cv2.imread(str(tmp_path / name), cv2.IMREAD_GRAYSCALE).astype(int)
    there = cv2.imread(str(kept), cv2.IMREAD_GRAYSCALE).astype(int)
    # encoders of JPEG differ by a level or two from one version to the next
    assert np.abs(drawn - there).max() <= (3 if kept.suffix == ".jpg" else 0)


@pytest.mark.parametrize(
    ("name", "obstacles", "radius", "start", "goal"),
    [
        ("arena", 3, 20.0, (40, 40), (600, 440)),
        ("photograph", 5, 18.0, (40, 440), (600, 40)),
        ("maze", None, 9.0, (20, 20), (620, 460)),
    ],
)
def test_a_picture_has_its_obstacles_and_a_path(
    name: str,
    obstacles: int | None,
    radius: float,
    start: tuple[float, float],
    goal: tuple[float, float],
) -> None:
    scene = vision.extract(cv2.imread(str(planner.sample(name)), cv2.IMREAD_GRAYSCALE))
    assert obstacles is None or len(scene.objects) == obstacles
    assert not vision.doubts_about(scene)
    path = planner.build_roadmap(scene, radius=radius).plan(start, goal)
    assert path
    assert path.min_clearance >= radius


def test_the_map_has_a_path_through_its_door() -> None:
    scene = planner.load_scene(planner.sample("rooms"))
    assert scene.units == "m"
    assert planner.build_roadmap(scene, radius=0.22).plan((-1.0, 1.0), (5.5, 2.5))


def test_another_name_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(planner.SceneError, match=r"no sample 'hall': .* arena, photograph, maze"):
        planner.sample("hall")
