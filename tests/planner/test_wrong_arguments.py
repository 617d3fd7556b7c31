"""What is no argument of a public function is refused where it comes in, by its name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import planner
from planner.scene import Bounds, CircleRecord, Scene, SceneObject
from tests.support.wrong_values import refuses

BOUNDS = (0, 0, 4, 3)
SCENE = Scene.from_polygons(
    [[(1.2, 0.0), (1.2, 0.9), (1.4, 0.9), (1.4, 0.0)]], [(2.0, 1.9, 0.4)], bounds=BOUNDS
)
ROADMAP = planner.build_roadmap(SCENE, 0.2)
HERE, THERE = (0.5, 0.5), (3.5, 0.5)
PATH = ROADMAP.plan(HERE, THERE)
LIMITS = planner.Limits(0.3, 0.5, 0.5, 2.0, 6.0, 5.0, 0.05, 0.002, 0.3, 0.12)
NODES, EDGES = [(0, 0), (5, 0)], [(0, 1)]
assert isinstance(PATH, planner.Path)


def fleet(**changes: Any) -> Any:
    wanted = {"roadmap": ROADMAP, "starts": [HERE], "goals": [THERE]}
    return planner.plan_fleet(**(wanted | changes))


def tasks(**changes: Any) -> Any:
    wanted = {"roadmap": ROADMAP, "robots": [HERE], "tasks": [THERE]}
    return planner.assign_tasks(**(wanted | changes))


def on_graph(**changes: Any) -> Any:
    wanted = {"nodes": NODES, "edges": EDGES, "radius": 0.1, "starts": [0], "goals": [1]}
    return planner.plan_on_graph(**(wanted | changes))


def plan(**changes: Any) -> Any:
    return ROADMAP.plan(**({"start": HERE, "goal": THERE} | changes))


def limits_with(speed: Any) -> Any:
    changed = planner.Limits(speed, 0.5, 0.5, 2.0, 6.0, 5.0, 0.05, 0.002, 0.3, 0.12)
    return planner.time_path(PATH, changed)


NUMBER = "a number"
TABLE: list[tuple[str, Callable[[Any], Any], str]] = [
    # the word that names the argument, the call, and what it takes all the same
    ("sites", planner.voronoi, "nothing"),
    ("roadmap", lambda it: fleet(roadmap=it), ""),
    ("starts", lambda it: fleet(starts=it), ""),
    ("goals", lambda it: fleet(goals=it), ""),
    ("radii", lambda it: fleet(radii=it), "None, a number"),
    ("limits", lambda it: fleet(limits=it), "None"),
    ("time_limit_s", lambda it: fleet(time_limit_s=it), NUMBER),
    ("improve", lambda it: fleet(improve=it), ""),
    ("seed", lambda it: fleet(seed=it), ""),
    ("roadmap", lambda it: tasks(roadmap=it), ""),
    ("robots", lambda it: tasks(robots=it), "nothing"),
    ("tasks", lambda it: tasks(tasks=it), "nothing"),
    ("radii", lambda it: tasks(radii=it), "None, a number"),
    ("limits", lambda it: tasks(limits=it), "None"),
    ("objective", lambda it: tasks(objective=it), ""),
    ("nodes", lambda it: on_graph(nodes=it), ""),
    ("edges", lambda it: on_graph(edges=it), "nothing"),
    ("radius", lambda it: on_graph(radius=it), NUMBER),
    ("starts", lambda it: on_graph(starts=it), ""),
    ("goals", lambda it: on_graph(goals=it), ""),
    ("time_limit_s", lambda it: on_graph(time_limit_s=it), NUMBER),
    ("roadmap", lambda it: planner.FleetSchedule.parked(it, [HERE]), ""),
    ("places", lambda it: planner.FleetSchedule.parked(ROADMAP, it), ""),
    ("text", lambda it: planner.read_scene_text(it), ""),
    ("scene", planner.write_scene_text, ""),
    ("sample", planner.sample, ""),
    ("path", lambda it: planner.time_path(it, LIMITS), ""),
    ("limits", lambda it: planner.time_path(PATH, it), ""),
    ("limits.speed", limits_with, NUMBER),
    ("clearance", lambda it: planner.time_path(PATH, LIMITS, clearance=it), "None"),
    ("dwell", lambda it: planner.time_path(PATH, LIMITS, dwell_s=it), "nothing"),
    ("path", lambda it: planner.round_corners(it, ROADMAP), ""),
    ("roadmap", lambda it: planner.round_corners(PATH, it), ""),
    ("prefer", lambda it: planner.round_corners(PATH, ROADMAP, prefer=it), ""),
    ("margin", lambda it: planner.round_corners(PATH, ROADMAP, margin=it), NUMBER),
    ("turning_radius", lambda it: planner.round_corners(PATH, ROADMAP, turning_radius=it), NUMBER),
    ("scene", lambda it: planner.build_roadmap(it, 0.2), ""),
    ("radius", lambda it: planner.build_roadmap(SCENE, it), NUMBER),
    ("spacing", lambda it: planner.build_roadmap(SCENE, 0.2, spacing=it), "None"),
    ("mode", lambda it: planner.build_roadmap(SCENE, 0.2, mode=it), ""),
    ("least_branch", lambda it: planner.build_roadmap(SCENE, 0.2, least_branch=it), NUMBER),
    ("lap", lambda it: planner.build_roadmap(SCENE, 0.2, lap=it), "None"),
    ("start", lambda it: plan(start=it), "numbers, an array"),
    ("goal", lambda it: plan(goal=it), "numbers, an array"),
    ("via", lambda it: plan(via=it), "nothing"),
    ("prefer", lambda it: plan(prefer=it), ""),
    ("order", lambda it: plan(order=it), ""),
    ("alternatives", lambda it: plan(alternatives=it), ""),
    ("margin", lambda it: plan(margin=it), NUMBER),
    ("near", lambda it: plan(near=it), "None"),
    ("points", ROADMAP.clearance, "nothing"),
    ("polyline", ROADMAP.path_clearance, ""),
    ("scene", ROADMAP.updated, ""),
    ("units", lambda it: Scene(it, SCENE.bounds, ()), ""),
    ("bounds", lambda it: Scene("m", it, ()), ""),
    ("bounds", lambda it: Scene("m", Bounds(it, 0, 4, 3), ()), "a negative number, a number"),
    ("object", lambda it: Scene("m", SCENE.bounds, it), "nothing"),
    ("object", lambda it: Scene("m", SCENE.bounds, (it,)), ""),
    ("object 0", lambda it: Scene("m", SCENE.bounds, (SceneObject(0, it),)), "nothing"),
    ("object 0", lambda it: Scene("m", SCENE.bounds, (SceneObject(0, (it,)),)), ""),
    ("polygon", lambda it: Scene.from_polygons(it, bounds=BOUNDS), "nothing"),
    ("polygon 0", lambda it: Scene.from_polygons([it], bounds=BOUNDS), ""),
    ("circle", lambda it: Scene.from_polygons([], it, bounds=BOUNDS), "nothing"),
    ("circle 0", lambda it: Scene.from_polygons([], [it], bounds=BOUNDS), "numbers, an array"),
    ("bounds", lambda it: Scene.from_polygons([], [(1, 1, 0.2)], bounds=it), "None"),
    ("units", lambda it: Scene.from_polygons([], [(1, 1, 0.2)], units=it), ""),
    ("geometry", Scene.from_geo, ""),
    ("tolerance", SCENE.to_geo, "a number, inf"),
    ("bounds", SCENE.with_bounds, ""),
    ("object", lambda it: SCENE.replace_object(0, it), ""),
    ("least_area", SCENE.without_specks, NUMBER),
]


@pytest.mark.parametrize(("named", "call", "fine"), TABLE)
def test_what_is_no_argument_is_refused_by_its_name(
    named: str, call: Callable[[Any], Any], fine: str
) -> None:
    refuses(call, named, fine)


@pytest.mark.parametrize("wrong", [None, 3.5, b"x", ["a"], object()])
def test_a_file_has_a_name(wrong: Any) -> None:
    for call in (planner.load_scene, ROADMAP.save):
        with pytest.raises(TypeError, match=r"path is a .*: must be the name of a file"):
            call(wrong)


def test_a_refusal_is_no_path_to_go_on_with(tmp_path: Path) -> None:
    stuck = ROADMAP.plan(HERE, (2.0, 1.9))
    assert isinstance(stuck, planner.NoPath)
    with pytest.raises(TypeError, match="path is a NoPath: must be a Path"):
        planner.time_path(stuck, LIMITS)
    with pytest.raises(TypeError, match="path is a NoPath: must be a Path"):
        planner.round_corners(stuck, ROADMAP)


def test_the_number_of_an_object_is_a_whole_one() -> None:
    bucket = SceneObject(7, (CircleRecord((3.0, 2.0), 0.1),))
    for wrong in (None, 0.5, "0", [0]):
        with pytest.raises(TypeError, match=r"number = .*: must be a whole number"):
            SCENE.replace_object(wrong, bucket)
