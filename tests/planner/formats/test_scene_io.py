"""The scene text is read and written without loss, and hostile files give one clear error."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from planner.formats.scene_io import load_scene, read_scene_text, save_scene, write_scene_text
from planner.formats.scene_json import scene_to_json
from planner.formats.scene_json_reader import read_scene_json
from planner.scene import (
    Arc,
    ArcRecord,
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

PLAIN = """\
# five records of the paper
P (1,2)
S (0,0) (3,4)
C (10, 10) 2.5
A 3 (20,20)(25,22)(30,20)   # an arc's polygonal line
L 4 (40,40)(60,40)(60,60)(40,60)
"""

coordinate = st.floats(-1e9, 1e9) | st.integers(-4000, 4000).map(float) | st.just(-0.0)
vec = st.tuples(coordinate, coordinate)
positive = st.floats(1e-9, 1e9)
residual = st.just(0.0) | st.floats(0, 1e3)
text = st.text(st.characters(codec="utf-8"), max_size=20)


@st.composite
def arc_from(draw, start):
    """An arc that begins at ``start`` and whose other end lies on the same circle."""
    radius, a0, a1 = draw(st.tuples(st.floats(0.5, 100), st.floats(-4, 4), st.floats(-4, 4)))
    cx, cy = start[0] - radius * math.cos(a0), start[1] - radius * math.sin(a0)
    end = (cx + radius * math.cos(a1), cy + radius * math.sin(a1))
    return Arc(start, end, (cx, cy), radius, draw(st.booleans()))


@st.composite
def chain(draw, closed):
    at = first = draw(st.tuples(st.floats(-1e5, 1e5), st.floats(-1e5, 1e5)))
    edges = []
    for _ in range(draw(st.integers(1, 5))):
        edge = draw(arc_from(at)) if draw(st.booleans()) else Segment(at, draw(vec))
        at = edge.end
        if not abs(at[0]) + abs(at[1]) < 2e5:
            at, edge = (0.0, 0.0), Segment(edge.start, (0.0, 0.0))
        edges.append(edge)
    if closed and at != first:
        edges.append(Segment(at, first))
    return tuple(edges)


record = st.one_of(
    st.builds(PointRecord, vec, residual),
    st.builds(SegmentRecord, vec, vec, residual),
    st.builds(CircleRecord, vec, positive, residual),
    st.builds(ArcRecord, chain(closed=False), residual),
    st.builds(PolygonRecord, chain(closed=True), residual),
)
border = st.lists(record, min_size=1, max_size=3).map(tuple)


@st.composite
def scenes(draw):
    ids = draw(st.lists(st.integers(0, 999), unique=True, max_size=4))
    x, y = draw(vec)
    return Scene(
        units=draw(st.sampled_from(["px", "m", "cells"])),
        bounds=Bounds(x, y, x + draw(st.floats(1, 1e9)), y + draw(st.floats(1, 1e9))),
        objects=tuple(
            SceneObject(k, draw(border), tuple(draw(st.lists(border, max_size=2)))) for k in ids
        ),
        bounds_given=draw(st.booleans()),
        size=draw(st.none() | st.tuples(st.integers(1, 9999), st.integers(1, 9999))),
        border_pixels=draw(st.integers(0, 99999)),
        binarisation=draw(
            st.none()
            | st.builds(
                Binarisation, text, st.floats(-1e3, 1e3), st.sampled_from(["dark", "light"]), text
            )
        ),
        timings_ms=draw(st.dictionaries(text, st.floats(0, 1e6), max_size=3)),
        remarks=tuple(draw(st.lists(text, max_size=3))),
    )


@settings(max_examples=150)
@given(scenes())
def test_what_is_written_is_read_back_equal(scene):
    written = write_scene_text(scene)
    assert read_scene_text(written) == scene
    assert write_scene_text(read_scene_text(written)) == written


@settings(max_examples=150)
@given(scenes())
def test_what_is_written_as_json_is_read_back_equal(scene):
    written = json.dumps(scene_to_json(scene), allow_nan=False)
    assert read_scene_json(written) == scene
    assert scene_to_json(read_scene_json(written)) == json.loads(written)


@settings(max_examples=50)
@given(scenes())
def test_a_reader_of_the_plain_format_sees_only_the_papers_records(scene):
    number = r"-?[0-9.]+(?:e[+-]?[0-9]+)?"
    point = rf"\({number},{number}\)"
    shapes = [
        rf"P {point}",
        rf"S {point} {point}",
        rf"C {point} {number}",
        rf"[AL] [0-9]+ (?:{point})+",
    ]
    plain = [line for line in write_scene_text(scene).splitlines() if not line.startswith("#")]
    assert all(any(re.fullmatch(shape, line) for shape in shapes) for line in plain)
    borders = [b for o in scene.objects for b in (o.records, *o.holes)]
    assert len(plain) == sum(len(b) for b in borders)


def test_the_papers_five_records_are_read():
    scene = read_scene_text(PLAIN)
    assert [type(o.records[0]) for o in scene.objects] == [
        PointRecord,
        SegmentRecord,
        CircleRecord,
        ArcRecord,
        PolygonRecord,
    ]
    assert scene.units == "px"
    assert scene.objects[2].records[0] == CircleRecord((10.0, 10.0), 2.5)
    assert len(scene.objects[3].records[0].edges) == 2
    assert len(scene.objects[4].records[0].edges) == 4
    assert scene.vertex_count == 1 + 2 + 1 + 3 + 4


def test_a_plain_file_gets_generous_bounds_that_say_they_were_derived():
    scene = read_scene_text("L 3 (0,0)(30,0)(0,40)")
    assert not scene.bounds_given
    assert scene.bounds == Bounds(-50.0, -50.0, 80.0, 90.0)
    lone = read_scene_text("P (5,5)").bounds
    assert lone.width > 0
    assert lone.height > 0


@pytest.mark.parametrize(
    "line",
    [
        "L 3 (0,0)(3,0)(0,4)",
        "l 3 (0, 0) (3, 0) (0, 4)",
        "\tL  3   ( 0 , 0 ),( 3 ,0 )\t(0,4)  ",
        "L 3 (0 0)(3.0 0e0)(+0 4.)",
        "L 3 (0,0)(3,0)(0,4) # comment\r",
        "\ufeffL 3 (0,0)(3,0)(0,4)",
    ],
)
def test_spaces_and_spellings_do_not_matter(line):
    assert read_scene_text(line) == read_scene_text("L 3 (0,0)(3,0)(0,4)")


def test_polygons_of_strangers_are_turned_clockwise_as_seen_on_the_screen():
    forth = read_scene_text("L 4 (0,0)(4,0)(4,4)(0,4)").objects
    back = read_scene_text("L 4 (0,0)(0,4)(4,4)(4,0)").objects
    assert forth == back
    assert forth[0].records[0].edges[0] == Segment((0.0, 0.0), (4.0, 0.0))


@pytest.mark.parametrize(
    ("source", "place", "what"),
    [
        ("", None, "no records"),
        ("# nothing\n\n", None, "no records"),
        ("P (1,2", "1:7", "expected ')'"),
        ("P (nan,2)", "1:4", "finite number, found 'nan'"),
        ("P (1,inf)", "1:6", "finite"),
        ("P (1,1e400)", "1:6", "must lie within"),
        ("P (1,2) (3,4)", "1:9", "nothing more"),
        ("P (1;2)", "1:5", "expected y"),
        ("S (1,2)", "1:8", "expected '('"),
        ("\n C (1,2) 0", "2:10", "must be > 0"),
        ("C (1,2) -3", "1:9", "must be > 0"),
        ("C (1,2)", "1:8", "a radius"),
        ("L 4 (1,1)(2,2)(3,1)", "1:3", "4 vertices announced, 3 found"),
        ("L 999999999 (1,1)", "1:3", "vertices announced"),
        ("L 99999999999999999999 (1,1)", "1:3", "whole number"),
        ("L -1 (1,1)", "1:3", "whole number >= 1"),
        ("L 0", "1:3", "whole number >= 1"),
        ("A 1 (1,1)", "1:3", "whole number >= 2"),
        ("Q (1,2)", "1:1", "'Q' is not a record"),
        ("P 1 2", "1:3", "expected '('"),
        ("P (1_0,2)", "1:4", "expected x"),
        ("P (٣,2)", "1:4", "expected x"),
    ],
)
def test_a_bad_record_is_named_with_its_place(source, place, what):
    with pytest.raises(SceneError) as caught:
        read_scene_text(source, "arena.txt")
    message = str(caught.value)
    assert message.startswith("arena.txt:" + (f"{place}:" if place else ""))
    assert what in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("extension", "what"),
    [
        ("#@ units mm", "px, m or cells"),
        ("#@ units px\n#@ units px", "twice"),
        ("#@ bounds given 0 0 0 1", "positive width"),
        ("#@ bounds given 0 0 1", "y_max"),
        ("#@ bounds maybe 0 0 1 1", "given or derived"),
        ("#@ size 0 3", "whole number >= 1"),
        ("#@ binarisation {", "not JSON"),
        ("#@ binarisation {}", "needs method"),
        ('#@ timings_ms {"a": "b"}', "object of numbers"),
        ('#@ timings_ms {"a": NaN}', "NaN"),
        ("#@ remark 3", "JSON string"),
        ("#@ hole", "needs an object"),
        ("#@ object 1\n#@ hole\nP (1,1)", "no records"),
        ("#@ object 1\nP (1,1)\n#@ object 1", "twice"),
        ("#@ object 1", "no records"),
        ("P (1,1)\n#@ object 1", "above the first object"),
        ("#@ arc 1 0 0 1 cw", "no record comes before this"),
        ("P (1,1)\n#@ arc 1 0 0 1 cw", "only the edges of A and L"),
        ("A 2 (1,0)(0,1)\n#@ arc 2 0 0 1 cw", "the record has 1"),
        ("A 2 (1,0)(0,1)\n#@ arc 1 0 0 1 left", "cw or ccw"),
        ("A 2 (1,0)(0,1)\n#@ arc 1 9 9 1 cw", "off its circle"),
        ("A 2 (1,0)(0,1)\n#@ arc 1 0 0 -1 cw", "must be > 0"),
        ("#@ colour red", "not an extension"),
        ("#@", "expected an extension"),
        ("#@ remark " + "[" * 100_000, "remark"),
    ],
)
def test_a_bad_extension_is_named_with_its_place(extension, what):
    with pytest.raises(SceneError, match=r"^arena\.txt:") as caught:
        read_scene_text("#@ clearway.scene/1\n" + extension, "arena.txt")
    assert what in str(caught.value)


def test_extensions_are_plain_comments_without_the_first_line():
    assert read_scene_text("#@ units m\nP (1,2)").units == "px"


@settings(max_examples=300)
@given(st.text(st.sampled_from("PSCALpq()0123456789.,-+e #@\n\tnaif\x00\u2028"), max_size=80))
@example("P (1,2)\x0bP (3,4)")
def test_no_text_makes_the_reader_fail_other_than_by_a_scene_error(source):
    try:
        scene = read_scene_text(source)
    except SceneError:
        return
    assert read_scene_text(write_scene_text(scene)) == scene


@settings(max_examples=200)
@given(st.data())
def test_a_damaged_file_gives_a_scene_or_a_scene_error(data):
    source = write_scene_text(data.draw(scenes()))
    at = data.draw(st.integers(0, len(source)))
    junk = data.draw(st.text(max_size=3))
    cut = data.draw(st.integers(0, 5))
    try:
        read_scene_text(source[:at] + junk + source[at + cut :])
    except SceneError:
        return


@settings(max_examples=100)
@given(st.binary(max_size=60))
def test_any_bytes_in_a_file_give_a_scene_or_a_scene_error(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("fuzz") / "scene.txt"
    path.write_bytes(data)
    try:
        scene = load_scene(path)
    except SceneError:
        return
    assert scene.objects


def test_edges_that_do_not_connect_are_not_written():
    edges = (Segment((0.0, 0.0), (1.0, 0.0)), Segment((1.0, 0.5), (0.0, 0.0)))
    scene = Scene("px", Bounds(0, 0, 9, 9), (SceneObject(0, (PolygonRecord(edges),)),))
    with pytest.raises(SceneError, match="edge 1 ends at"):
        write_scene_text(scene)


@pytest.mark.parametrize("value", [-1e16, 1e16, 1e300])
def test_numbers_beyond_the_limit_are_not_written(value):
    scene = Scene("px", Bounds(0, 0, 9, 9), (SceneObject(0, (PointRecord((value, 0.0)),)),))
    with pytest.raises(SceneError, match="must lie within"):
        write_scene_text(scene)


def test_a_scene_survives_the_disk(tmp_path: Path):
    scene = read_scene_text(PLAIN)
    save_scene(scene, tmp_path / "arena.txt")
    assert load_scene(tmp_path / "arena.txt") == scene


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"\x89PNG\r\n\x1a\n....", "vision.extract"),
        (b"\xff\xd8\xff\xe0 jpeg", "vision.extract"),
        (b"P5\n2 2\n255\n....", "vision.extract"),
        (b"P (1,2)\x00", "NUL"),
        (b"\xfe\xfe\xfe", "not UTF-8"),
        (b"", "no records"),
    ],
)
def test_what_is_no_scene_file_is_refused_with_a_hint(tmp_path, data, what):
    path = tmp_path / "thing"
    path.write_bytes(data)
    with pytest.raises(SceneError, match=re.escape(str(path))) as caught:
        load_scene(path)
    assert what in str(caught.value)


def test_a_missing_file_and_a_folder_are_scene_errors(tmp_path):
    with pytest.raises(SceneError, match="No such file"):
        load_scene(tmp_path / "none.txt")
    with pytest.raises(SceneError, match="directory"):
        load_scene(tmp_path)
    with pytest.raises(SceneError, match="null"):
        load_scene("a\x00b")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("scene.txt", "P (1,2)\nC (10,10) 3\n"),
        ("grid.map", "type octile\nheight 1\nwidth 3\nmap\n..@\n"),
        ("map.yaml", "image: m.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n"),
    ],
)
def test_a_byte_order_mark_before_a_text_is_no_part_of_it(
    name: str, text: str, tmp_path: Path
) -> None:
    (tmp_path / "m.pgm").write_text("P2\n3 1\n255\n255 0 255\n")
    path = tmp_path / name
    path.write_text(text)
    plain = load_scene(path)
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert load_scene(path) == plain
