"""Scenes, roadmaps and paths in a Python session: short to look at, easy to change."""

from __future__ import annotations

import pytest

import planner
from planner import CircleRecord, SceneObject

SCENE = """#@ clearway.scene/1
#@ units m
#@ bounds given 0 0 4 3
C (2,1.2) 0.5
C (1,2.5) 0.2
"""


@pytest.fixture
def scene() -> planner.Scene:
    return planner.read_scene_text(SCENE)


def test_scene_roadmap_and_path_are_one_line_each(scene):
    roadmap = planner.build_roadmap(scene, 0.2)
    path = roadmap.plan((0.5, 0.5), (3.5, 0.5), alternatives=1)
    assert repr(scene) == "<Scene of 2 objects, 4 x 3 m>"
    assert repr(roadmap).startswith("<Roadmap for radius 0.2 m, ")
    assert repr(path).startswith("<Path of ")
    for shown in (repr(scene), repr(roadmap), repr(path)):
        assert len(shown) < 100
        assert "\n" not in shown


def test_no_path_counts_as_false_and_a_path_as_true(scene):
    roadmap = planner.build_roadmap(scene, 0.2)
    assert roadmap.plan((0.5, 0.5), (3.5, 0.5))
    assert not roadmap.plan((0.5, 0.5), (2.0, 1.2))


def test_an_object_is_replaced_moved_split_or_taken_out(scene):
    one, other = scene.objects
    moved = SceneObject(one.id, (CircleRecord((3.0, 1.2), 0.5),))
    assert scene.replace_object(0, moved).objects == (moved, other)
    assert scene.replace_object(1).objects == (one,)
    assert scene.replace_object(1, moved, other).objects == (one, moved, other)
    assert scene.objects == (one, other)
    assert scene.replace_object(0, one) == scene


@pytest.mark.parametrize("number", [2, -1])
def test_an_object_that_is_not_there_is_not_replaced(scene, number):
    with pytest.raises(IndexError, match=f"object {number}: the scene has 2, numbered from 0"):
        scene.replace_object(number)
