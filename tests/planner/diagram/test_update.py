"""A changed scene's roadmap is the one that building anew gives."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

import planner
from planner.borders import generator_kernels
from planner.borders.generators import Borders
from planner.delaunay import insertion_kernels, removal_kernels
from planner.diagram.update import match_objects
from planner.path import Path
from planner.roadmap.graph import lay_strands
from planner.roadmap.roadmap import Roadmap
from planner.scene import Bounds, CircleRecord, FloatArray, Scene, SceneObject
from planner.scene.primitive_kernels import ARC, CIRCLE
from tests.support.scenes.planner_scenes import box, hand_made, polygon, scene_of

Edge = tuple[float, ...]


def _edges(roadmap: Roadmap) -> FloatArray:
    """Every edge of the graph: its two ends, clearance and length, sorted; a loop has no ends."""
    c = roadmap.clipped.chains
    rows = []
    for strand in lay_strands(roadmap.clipped.chains, roadmap.kept):
        ids = [k for k, _ in strand.chains]
        ends = sorted(np.round(c.node_xy[[strand.u, strand.v]], 4).tolist())
        if strand.u == strand.v:
            ends = [[0.0, 0.0], [0.0, 0.0]]
        clearance, length = c.clearance[ids].min(), c.length[ids].sum()
        rows.append([*ends[0], *ends[1], round(float(clearance), 5), float(length)])
    return np.array(sorted(rows)).reshape(-1, 6)


def _judge(updated: Roadmap, rng: np.random.Generator) -> None:
    rebuilt = planner.build_roadmap(updated.scene, updated.radius)
    _judge_borders(updated.borders, rebuilt.borders)
    one, other = _edges(updated), _edges(rebuilt)
    assert one.shape == other.shape
    assert one[:, :5] == pytest.approx(other[:, :5], abs=1e-3)
    # the polylines' points may differ, within their tolerance of the bisectors
    assert one[:, 5] == pytest.approx(other[:, 5], rel=5e-3, abs=0.02)
    places = rng.uniform((2.0, 2.0), (157.0, 117.0), (6, 2))
    assert updated.clearance(places) == pytest.approx(rebuilt.clearance(places))
    for start, goal in zip(places[:3], places[3:], strict=True):
        mine, theirs = (r.plan(start, goal, prefer="length") for r in (updated, rebuilt))
        assert isinstance(mine, Path) == isinstance(theirs, Path)
        if isinstance(mine, Path) and isinstance(theirs, Path):
            assert mine.length == pytest.approx(theirs.length, rel=0.01)
            assert mine.min_clearance >= updated.radius - 1e-6


def _judge_borders(updated: Borders, rebuilt: Borders) -> None:
    """Pieces, how they join, boxes and tree are the very same."""
    for f in fields(Borders):
        one, other = getattr(updated, f.name), getattr(rebuilt, f.name)
        pairs = zip(one, other, strict=True) if isinstance(one, tuple) else [(one, other)]
        assert all(np.array_equal(a, b) for a, b in pairs), f.name


def _apart(rng: np.random.Generator, count: int) -> list[SceneObject]:
    """Convex polygons and circles, one to a cell of a grid: none touch."""
    cells = [(x, y) for x in range(6) for y in range(4)]
    objects = []
    for i in rng.permutation(len(cells))[:count]:
        x, y = 18.0 + 25.0 * cells[i][0], 18.0 + 28.0 * cells[i][1]
        x, y = x + rng.uniform(-2.0, 2.0), y + rng.uniform(-2.0, 2.0)
        size = float(rng.uniform(3.0, 9.0))
        if rng.random() < 0.4:
            objects.append(SceneObject(0, (CircleRecord((x, y), size),)))
            continue
        k = int(rng.integers(3, 8))
        a = (np.arange(k) + rng.uniform(-0.3, 0.3, k)) * 2.0 * np.pi / k
        corners = zip((x + size * np.cos(a)).tolist(), (y + size * np.sin(a)).tolist(), strict=True)
        objects.append(SceneObject(0, (polygon(list(corners)),)))
    return objects


def _numbered(objects: list[SceneObject]) -> tuple[SceneObject, ...]:
    return tuple(replace(o, id=i) for i, o in enumerate(objects))


@pytest.mark.parametrize("seed", range(12))
def test_objects_that_come_go_and_move_give_the_roadmap_built_anew(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pool = _apart(rng, 14)
    objects, others = pool[:8], pool[8:]
    roadmap = planner.build_roadmap(scene_of(*_numbered(objects)), float(rng.uniform(1.5, 4.0)))
    for _ in range(5):
        choice = int(rng.integers(3))
        at = int(rng.integers(len(objects)))
        if choice == 0 and len(objects) > 4:
            others.append(objects.pop(at))
        elif choice == 1 and others:
            objects.insert(at, others.pop(0))
        else:
            others.append(objects[at])
            objects[at] = others.pop(0)
        roadmap = roadmap.updated(scene_of(*_numbered(objects)))
        _judge(roadmap, rng)


@pytest.mark.parametrize("name", ["U", "lattice of boxes", "touching boxes", "crossing boxes"])
def test_an_object_put_into_a_difficult_scene_and_taken_out_again(name: str) -> None:
    scene = hand_made()[name]
    before = planner.build_roadmap(scene, 2.5)
    more = replace(scene, objects=(*scene.objects, SceneObject(99, (box(10, 55, 14, 61),))))
    within = before.updated(more)
    _judge(within, np.random.default_rng(0))
    after = within.updated(scene)
    _judge(after, np.random.default_rng(1))


def test_the_old_roadmap_stays_as_it_was() -> None:
    scene = hand_made()["lattice of boxes"]
    roadmap = planner.build_roadmap(scene, 2.5)
    before = _edges(roadmap)
    counts = dict(roadmap.counts)
    roadmap.updated(replace(scene, objects=scene.objects[1:]))
    assert (_edges(roadmap) == before).all()
    assert dict(roadmap.counts) == counts


def test_other_bounds_and_the_papers_mode_are_built_anew() -> None:
    scene = hand_made()["one box"]
    wider = scene.with_bounds(Bounds(-0.5, -0.5, 200.0, 150.0))
    assert planner.build_roadmap(scene, 4.0).updated(wider).scene is wider
    paper = planner.build_roadmap(scene, 4.0, mode="paper").updated(scene)
    assert paper.mode == "paper"


def test_objects_are_matched_by_what_they_are_and_once_each() -> None:
    a, b = (
        SceneObject(0, (box(10, 10, 20, 20),)),
        SceneObject(1, (CircleRecord((50.0, 50.0), 9.0),)),
    )
    again = SceneObject(7, (CircleRecord((50.0, 50.0), 9.0),))
    assert match_objects([a, b], [again, a, again]) == [1, 0, -1]
    with_hole = replace(a, holes=((CircleRecord((15.0, 15.0), 2.0),),))
    assert match_objects([a], [with_hole]) == [-1]


@pytest.mark.parametrize("seed", range(8))
def test_a_triangulation_without_sites_is_that_of_the_others(seed: int) -> None:
    rng = np.random.default_rng(seed)
    inner = rng.random((int(rng.integers(30, 300)), 2))
    if seed % 2:
        inner = np.unique(np.round(inner * 12.0) / 12.0, axis=0)
    sites = np.concatenate([inner, [(-1.0, -1.1), (2.2, -1.0), (2.0, 2.5), (-1.0, 2.0)]])
    n = len(sites)
    _, order, xy, tri, circ, *_ = insertion_kernels.triangulate(sites, 5)
    place = np.argsort(order)
    gone = rng.choice(len(inner), len(inner) // 2, replace=False)
    assert removal_kernels.remove(xy, n + 5, tri, circ, place[gone])
    rest = np.setdiff1d(np.arange(n), gone)
    _, other, _, fresh, *_ = insertion_kernels.triangulate(np.ascontiguousarray(sites[rest]), 0)
    want = _triangles(fresh, place[rest[other]], n + 5)
    got = _triangles(tri, np.arange(n + 5), n + 5)
    # of cocircular sites any triangulation will do
    assert len(want) == len(got) if seed % 2 else want == got


def _triangles(tri: np.ndarray, number: np.ndarray, ghost: int) -> set[frozenset[int]]:
    rows = tri.reshape(-1, 8)[:, :3].astype(np.int64)
    number = np.append(number, ghost)
    rows = rows[rows[:, 0] != insertion_kernels.DEAD]
    return {frozenset(number[row].tolist()) for row in rows}


def test_an_object_on_the_hull_is_taken_out_by_building_anew() -> None:
    scene: Scene = scene_of(box(-30, 40, 60, 80), box(90, 60, 100, 70))
    roadmap = planner.build_roadmap(scene, 4.0)
    _judge(roadmap.updated(replace(scene, objects=scene.objects[1:])), np.random.default_rng(0))


@pytest.mark.parametrize("radius", [1e-6, 0.1, 2.0, 30.0])
@pytest.mark.parametrize("sweep", [0.01, 3.0, 6.0, None])
def test_round_objects_have_no_more_generators_than_there_is_room_for(
    radius: float, sweep: float | None
) -> None:
    kind = np.array([CIRCLE if sweep is None else ARC], np.int8)
    data = np.zeros((1, 9))
    data[0, :5] = 50.0, 50.0, radius, 0.0, 0.0 if sweep is None else sweep
    none = np.empty(0, np.int32)
    backwards, at = np.zeros(1, np.bool_), np.empty((0, 2))
    disc = 50.0, 50.0, 100.0
    sites, _ = generator_kernels.place_generators(
        kind, data, backwards, at, none, none, disc, 14.0, 1000
    )
    assert len(sites) <= generator_kernels.count_generators(kind, data, backwards, disc, 14.0)


ROOM = (
    "L 4 (142.3,94.2)(209.7,94.2)(209.7,165.5)(142.3,165.5)\n#@ hole\n"
    "L 4 (147.4,99.2)(147.4,160.4)(204.6,160.4)(204.6,99.2)\n"
)
TRIANGLE = "L 3 (172.0627,222.85404)(167.73702,225.03469)(188.37724,205.59055)\n"
BENT_LINE = (
    "A 2 (283.3045,253.15567)(304.91266,244.00006)\n#@ arc 1 298.600123 259.178368 16.4386459 cw\n"
)
CRESCENT = (
    "L 4 (219.51578973320082,197.69854144355992)(232.9776335011897,101.72036734025923)"
    "(231.9515634177322,102.30883942340476)(218.69120456354273,196.85049751380853)\n"
    "#@ arc 1 164.4226489217425 141.03804674236653 79.02952501600359 cw\n"
    "#@ arc 3 164.4226489217425 141.03804674236653 77.84668132015523 ccw\n"
)
STAR = (
    "L 6 (146.9656,193.35257)(141.79243,209.82865)(121.25639,166.59815)(134.51859,164.29359)"
    "(148.94824,164.5549)(154.37848,157.62161)\n"
)
FRAMES = (
    "L 4 (43.89163,219.019546)(182.013354,219.019546)(182.013354,280.477788)(43.89163,280.477788)\n"
    "#@ hole\n"
    "L 4 (57.3658,232.4937)(57.3658,267.0036)(168.5392,267.0036)(168.5392,232.4937)\n"
    "#@ object 8\n"
    "L 4 (180.77991,180.592339)(265.613505,180.592339)(265.613505,290.167402)"
    "(180.77991,290.167402)\n"
    "#@ hole\n"
    "L 4 (191.4613,191.2737)(191.4613,279.486)(254.9321,279.486)(254.9321,191.2737)\n"
)


@pytest.mark.parametrize(
    ("goes", "stays", "radius"),
    [
        (ROOM, TRIANGLE + "#@ object 2\n" + BENT_LINE, 14.23664061472734),
        (STAR, CRESCENT + "#@ object 2\n" + FRAMES, 9.974665059287808),
    ],
)
def test_what_was_refined_for_an_object_goes_with_it(goes: str, stays: str, radius: float) -> None:
    head = "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n"
    before = planner.read_scene_text(head + "#@ object 1\n" + goes + "#@ object 9\n" + stays)
    after = planner.read_scene_text(head + "#@ object 9\n" + stays)
    updated = planner.build_roadmap(before, radius).updated(after)
    rebuilt = planner.build_roadmap(after, radius)
    assert _places(updated) == _places(rebuilt)
    assert _edges(updated)[:, :5] == pytest.approx(_edges(rebuilt)[:, :5], abs=1e-3)


def _places(roadmap: Roadmap) -> list[list[float]]:
    """Where the diagram's generators are, those added by refining included."""
    places: list[list[float]] = np.round(roadmap.agvd.generators.sites, 6).tolist()
    return sorted(places)


@pytest.mark.parametrize("goes", [0, 1, 2])
def test_one_of_three_objects_that_coincide_is_taken_out(goes: int) -> None:
    arc = "A 2 (290,150)(155,227.9423)\n#@ arc 1 200 150 90 ccw\n"
    head = "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n"
    scene = planner.read_scene_text(head + "".join(f"#@ object {i}\n{arc}" for i in range(3)))
    left = tuple(o for i, o in enumerate(scene.objects) if i != goes)
    updated = planner.build_roadmap(scene, 16.3).updated(replace(scene, objects=left))
    one = planner.build_roadmap(replace(scene, objects=left[:1]), 16.3)
    assert len(updated.chains) == len(one.chains)
    # the polylines' points may differ, within their tolerance of the bisectors
    assert np.sort(updated.chains.length) == pytest.approx(np.sort(one.chains.length), rel=1e-3)
