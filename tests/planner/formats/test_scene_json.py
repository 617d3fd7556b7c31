"""A scene as JSON: every bad member is named with its place, and optional ones may be missing."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from planner.formats.scene_io import load_scene
from planner.formats.scene_json import scene_to_json
from planner.formats.scene_json_reader import read_scene_json
from planner.scene import (
    Arc,
    Binarisation,
    Bounds,
    CircleRecord,
    PointRecord,
    PolygonRecord,
    Scene,
    SceneError,
    SceneObject,
    Segment,
    SegmentRecord,
)


def json_with(place: str, value: object) -> str:
    """A good scene in which the member at ``place`` is another; ``...`` leaves it out."""
    arc = Arc((6.0, 0.0), (0.0, 0.0), (3.0, 0.0), 3.0, ccw=True)
    objects = (
        SceneObject(0, (PolygonRecord((Segment((0.0, 0.0), (6.0, 0.0)), arc)),)),
        SceneObject(1, (CircleRecord((20.0, 20.0), 4.0),), ((PointRecord((20.0, 20.0)),),)),
        SceneObject(2, (SegmentRecord((1.0, 30.0), (9.0, 30.0)),)),
    )
    how = Binarisation("otsu", 128.0, "dark", "why")
    scene = Scene("px", Bounds(0.0, 0.0, 40.0, 40.0), objects, size=(40, 40), binarisation=how)
    document: object = scene_to_json(scene)
    steps: list[str | int] = [int(s) if s.isdigit() else s for s in place.split(".") if s]
    if not steps:
        return json.dumps(value)
    holder = document
    for step in steps[:-1]:
        holder = holder[step]
    if value is ...:
        del holder[steps[-1]]
    else:
        holder[steps[-1]] = value
    return json.dumps(document)


@pytest.mark.parametrize(
    ("place", "value", "what"),
    [
        ("", [], "schema None: must be 'clearway.scene/1'"),
        ("", {}, "schema None: must be 'clearway.scene/1'"),
        ("", {"type": "FeatureCollection"}, "Scene.from_geo takes GeoJSON"),
        ("schema", "clearway.plan/1", "schema 'clearway.plan/1': must be 'clearway.scene/1'"),
        ("schema", ["a"] * 999, "must be 'clearway.scene/1'"),
        ("units", ..., "units: is missing: must be one of px, m, cells"),
        ("units", "inch", "units = 'inch': must be one of px, m, cells"),
        ("bounds", ..., "bounds: is missing: must be a list of 4 numbers"),
        ("bounds", [0, 0, 1], "must be a list of 4 numbers"),
        ("bounds", [0, 0, 0, 9], "must be x_min, y_min, x_max, y_max, the least first"),
        ("bounds.2", "9", "bounds[2] = '9': must be a number within +-1e+15"),
        ("bounds_given", 1, "bounds_given = 1: must be true or false"),
        ("size", [4], "size = [4]: must be width and height"),
        ("size.0", 0, "size[0] = 0: must be a whole number >= 1"),
        ("counts", 3, "counts = 3: must be an object"),
        ("counts.border_pixels", -1, "must be a whole number >= 0"),
        ("binarisation.polarity", "auto", "must be one of dark, light"),
        ("binarisation.threshold", True, "must be a number"),
        ("timings_ms", [], "timings_ms = []: must be an object of numbers"),
        ("timings_ms", {"load": None}, "timings_ms.load: is missing: must be a number"),
        ("remarks", "well", "remarks = 'well': must be a list"),
        ("remarks", [3], "remarks[0] = 3: must be a string"),
        ("remarks", ["\ud800"], "must be a string of whole characters"),
        ("objects", ..., "objects: is missing: must be a list"),
        ("objects.0", 7, "objects[0] = 7: must be an object"),
        ("objects.0.id", 1.5, "objects[0].id = 1.5: must be a whole number >= 0"),
        ("objects.1.id", 0, "objects[1].id = 0: must be another number: it is there twice"),
        ("objects.0.records", [], "must be a list of one record at least"),
        ("objects.1.holes.0", [], "objects[1].holes[0] = []: must be a list of one record"),
        ("objects.0.records.0.type", "Q", "must be one of P, S, C, A, L"),
        ("objects.0.records.0.edges", [], "must be a list of one edge at least"),
        ("objects.0.records.0.edges.1.kind", "spline", "must be one of segment, arc"),
        ("objects.0.records.0.edges.1.ccw", ..., "edges[1].ccw: is missing: must be true or false"),
        ("objects.0.records.0.edges.1.radius", -3.0, "edges[1].radius = -3.0: must be >= 0"),
        ("objects.0.records.0.edges.1.radius", 9.0, "edges[1]: the arc's start lies 6 off"),
        ("objects.0.records.0.edges.0.to", [7.0, 0.0], "must be [6.0, 0.0], where the next edge"),
        ("objects.1.records.0.center", [1, 2, 3], "must be a list of 2 numbers"),
        ("objects.1.records.0.radius", 1e16, "must be a number within +-1e+15"),
        ("objects.1.records.0.residual_px", "no", "must be a number"),
        ("objects.2.records.0.from", ..., "records[0].from: is missing"),
    ],
)
def test_a_bad_member_of_json_is_named_with_its_place(place, value, what):
    with pytest.raises(SceneError) as error:
        read_scene_json(json_with(place, value), "arena.json")
    message = str(error.value)
    assert what in message
    assert message.startswith("arena.json: ")
    assert "\n" not in message
    assert len(message) < 250


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ('{"schema": "clearway.scene/1",', "arena.json:1:31: not JSON (Expecting property name"),
        ('{"schema": NaN}', "not JSON (NaN is not a finite number)"),
        ('{"a": ' * 100_000, "arena.json: JSON nested too deeply"),
        ('{"a": ' + "9" * 5000 + "}", "arena.json: not JSON ("),
    ],
)
def test_what_is_no_json_is_refused_with_its_place(text, what):
    with pytest.raises(SceneError, match=re.escape(what)):
        read_scene_json(text, "arena.json")


def test_members_that_are_not_known_are_skipped_and_the_optional_ones_may_be_missing():
    document = json.loads(json_with("colour", "blue"))
    for key in ("size", "bounds_given", "counts", "binarisation", "timings_ms", "remarks"):
        del document[key]
    for one in document["objects"]:
        if not one["holes"]:
            del one["holes"]
    scene = read_scene_json(json.dumps(document))
    assert (len(scene.objects), scene.size, scene.bounds_given) == (3, None, True)


def test_a_scene_as_json_is_loaded_from_the_disk(tmp_path: Path):
    for name, bom in (("arena.json", ""), ("no suffix", "\ufeff \n")):
        (tmp_path / name).write_text(bom + json_with("remarks", ["hello"]), encoding="utf-8")
        assert load_scene(tmp_path / name).remarks == ("hello",)
