"""An arena that seems to have become empty holds the robot until a person has looked."""

from __future__ import annotations

import math

import numpy as np
import pytest

import vision
from navigation.loop.daemon import Daemon
from navigation.loop.seeing.eye import Glimpse
from navigation.loop.seeing.scene_doubt import SceneDoubt
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.run.virtual_world import VirtualWorld
from planner.scene import Scene
from tests.support.pictures import blank, box_and_disc
from tests.support.runs.virtual import cycle_until, is_driving, short_config
from vision.watch.camera_place import PlaceReport

EMPTY = vision.extract(blank(320, 240, 200))
SOUND = vision.extract(box_and_disc())
NOISE = vision.extract(
    np.random.default_rng(3).integers(0, 2, (300, 300)).astype(np.uint8).repeat(2, 0).repeat(2, 1)
    * 255
)


def after(*scenes: Scene) -> SceneDoubt:
    doubt = SceneDoubt()
    for scene in scenes:
        doubt.see(scene)
    return doubt


@pytest.mark.parametrize("first", [EMPTY, NOISE])
def test_a_first_scene_in_doubt_is_said_and_does_not_hold(first: Scene) -> None:
    doubt = after(first)
    assert doubt.remark
    assert doubt.hold is None


@pytest.mark.parametrize("scene", [EMPTY, NOISE])
def test_one_that_becomes_so_holds_until_it_is_accepted_or_over(scene: Scene) -> None:
    doubt = after(SOUND, scene)
    assert doubt.hold is not None
    assert "where 2 obstacles were seen before" in doubt.hold
    doubt.accept()
    assert doubt.hold is None
    doubt.see(SOUND)
    assert (doubt.hold, doubt.remark) == (None, None)
    doubt.see(scene)
    assert doubt.hold is not None, "what was accepted is over"


def test_accepting_a_sound_scene_accepts_nothing_later() -> None:
    doubt = after(SOUND)
    doubt.accept()
    doubt.see(EMPTY)
    assert doubt.hold is not None


def seen(place: PlaceReport, scene: Scene | None = None) -> Glimpse:
    return Glimpse(0.0, {}, scene, None, {}, place)


MOVED = PlaceReport(moved="the camera has moved: 5 of 5 fixed points", remarks=("marker 21",))
LOST = PlaceReport(lost="7 of 12 fixed points are not seen")


@pytest.mark.parametrize("floor_markers", [True, False])
def test_a_camera_that_has_moved_holds_whatever_is_accepted_until_it_is_back(
    floor_markers: bool,
) -> None:
    doubt = SceneDoubt(floor_markers=floor_markers)
    assert doubt.look(seen(PlaceReport(), SOUND)) == {"arena": "", "camera's place": ""}
    said = doubt.look(seen(MOVED))
    assert said["camera's place"] == f"{MOVED.moved}; marker 21"
    assert doubt.hold == MOVED.moved
    doubt.accept()
    assert doubt.hold == MOVED.moved
    doubt.look(seen(PlaceReport(remarks=("marker 21",))))
    assert doubt.hold is None, "a single marker holds nobody"


def test_points_that_vanished_are_accepted_by_a_person_where_no_markers_lie() -> None:
    doubt, marked = SceneDoubt(), SceneDoubt(floor_markers=True)
    for one in (doubt, marked):
        one.look(seen(LOST, SOUND))
        assert one.hold is not None
        one.accept()
    assert doubt.hold is None
    assert marked.hold == LOST.lost
    doubt.look(seen(LOST))
    assert doubt.hold is None
    doubt.look(seen(PlaceReport()))
    doubt.look(seen(LOST))
    assert doubt.hold == f"{LOST.lost}: look, then resume accepts it", "what was accepted is over"


def test_frames_without_a_word_on_the_camera_change_nothing() -> None:
    doubt = SceneDoubt()
    doubt.look(seen(MOVED, SOUND))
    doubt.look(Glimpse(0.1, {}, None, None))
    assert doubt.hold == MOVED.moved


ALONE = {
    "arena": None,
    "arena_text": "#@ clearway.scene/1\n#@ units m\n#@ bounds given 0 0 2.4 1.8\n",
    "obstacles": [{"record": "C (0.9,0.9) 0.15", "from_s": 0.0, "until_s": 6.0}],
}


def test_the_only_obstacle_vanishes_while_the_robot_drives() -> None:
    """With pictures: that one without contrast shows no obstacle, as an empty arena does."""
    config = short_config([{"x_m": 0.20, "y_m": 1.60}], simulation=ALONE)
    world = VirtualWorld(config)
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        cycle_until(daemon, is_driving)
        held = cycle_until(daemon, lambda now: now.mission.state is State.HOLDING)
        assert "where 1 obstacle was seen before: look, then resume accepts it" in held.sentence
        assert any("no obstacle was found" in trouble for trouble in held.troubles)
        cycle_until(daemon, lambda now: not now.link.moving)
        here = world.body.pose()[:2]
        until_s = world.clock() + 2.0
        stood = cycle_until(daemon, lambda _: world.clock() > until_s)
        assert stood.mission.state is State.HOLDING
        assert math.dist(here, world.body.pose()[:2]) < 0.001
        daemon.people.resume()
        cycle_until(daemon, lambda now: now.mission.state is State.DONE)
