"""Zones in a recording: every change, complete without any other file, in every part."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest
from foxglove.messages import SceneUpdate
from mcap.reader import make_reader

from navigation.config import Config, parse_config
from navigation.config.zones import ZoneSection
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.recording import files
from navigation.recording.events import ZonesChanged
from navigation.recording.foxglove import roadmap_message
from navigation.recording.json_bodies import configuration_body
from navigation.recording.reader import read_recording
from navigation.recording.zone_bodies import zones_body, zones_of
from navigation.run.replay import replay
from navigation.run.virtual_run import run_virtually
from planner.roadmap.roadmap import Roadmap
from planner.zones.areas import CircleArea
from planner.zones.zone import Zone
from tests.navigation.config.test_zones import ALL_KINDS, write_mask
from tests.navigation.config.texts import GOOD
from tests.support.runs.boundaries import several_robots
from tests.support.runs.recordings import EVERY, RecordedBench, make_recording
from tests.support.runs.virtual import short_config

DESK = Zone("desk", "keep_out", CircleArea((1.0, 1.0), 0.1 + 0.2), ("ada",))


@pytest.fixture
def zones(tmp_path: Path) -> tuple[Zone, ...]:
    """One of every kind, and a mask."""
    write_mask(tmp_path)
    text = GOOD + ALL_KINDS + "  - {name: old, kind: keep_out, mask: mask.yaml}\n"
    return tuple(one.zone() for one in parse_config(text, "run.yaml", tmp_path).zones)


def test_zones_are_read_back_without_loss_and_without_their_files(
    zones: tuple[Zone, ...], tmp_path: Path
) -> None:
    changed = ZonesChanged(1.5, 7, (*zones, DESK))
    text = json.dumps(zones_body(changed), allow_nan=False)
    (tmp_path / "mask.yaml").unlink()
    assert zones_of(json.loads(text)) == changed


@pytest.mark.parametrize(
    "area", [{}, {"polygon": [[0, 0]]}, {"circle": [1, 1, -1]}, {"mask": "a", "scene": "x"}]
)
def test_a_damaged_zone_is_an_error_of_the_reader_s(area: dict[str, object]) -> None:
    plain = zones_body(ZonesChanged(0.0, 1, (DESK,)))
    plain["zones"][0]["area"] = area
    with pytest.raises((ValueError, LookupError)):
        zones_of(plain)


def test_each_change_is_recorded_once_and_found_at_its_time(tmp_path: Path) -> None:
    def each(bench: RecordedBench) -> None:
        bench.frames(2)
        for zones in ((), (DESK,), (replace(DESK, robots=()),), ()):
            bench.revision += 1
            bench.recorder.zones(zones, bench.revision, bench.now_s)
            bench.frames(2)

    (file,) = make_recording(tmp_path, each, **EVERY)
    recording = read_recording(file)
    assert [one.zones for one in recording.zones] == [(DESK,), (replace(DESK, robots=()),), ()]
    begun_s, revision = recording.zones[0].time_s, recording.zones[0].revision
    assert recording.zones_in(revision - 1) == ()
    assert recording.zones_in(revision) == (DESK,)
    assert recording.zones_in(revision + 1) == (replace(DESK, robots=()),)
    assert recording.zones_at(begun_s - 0.001) == ()
    assert recording.zones_at(begun_s) == (DESK,)
    assert recording.zones_at(begun_s + 1000.0) == ()
    with file.open("rb") as opened:
        drawn = [
            schema.name
            for schema, channel, _ in make_reader(opened).iter_messages()
            if channel.topic == "/zones" and schema is not None
        ]
    assert drawn == ["foxglove.SceneUpdate"] * 3


def test_a_recording_without_zones_has_no_channel_for_them(tmp_path: Path) -> None:
    def each(bench: RecordedBench) -> None:
        bench.recorder.zones((), 0, bench.now_s)
        bench.frames(2)

    (file,) = make_recording(tmp_path, each, **EVERY)
    assert read_recording(file).zones == []
    assert b"/zones" not in file.read_bytes()


def test_a_further_file_begins_with_the_zones_in_force(tmp_path: Path) -> None:
    def each(bench: RecordedBench) -> None:
        bench.recorder.zones((DESK,), 0, bench.now_s)
        bench.frames(20)

    _, *further = make_recording(tmp_path, each, file_mb=1.0, **EVERY)
    assert further
    for file in further:
        recording = read_recording(file)
        assert [one.zones for one in recording.zones] == [(DESK,)]
        if recording.frames:
            first = min(recording.frames.values(), key=lambda seen: seen.captured_s)
            assert recording.zones_at(first.captured_s) == (DESK,)


@pytest.mark.parametrize(
    "config", [short_config([{"x_m": 2.2, "y_m": 1.6}]), several_robots()], ids=["one", "several"]
)
def test_the_recorded_roadmap_goes_around_keep_out_zones_in_force(
    config: Config, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Roadmap] = []

    def draw(roadmap: Roadmap, time_ns: int) -> SceneUpdate:
        drawn.append(roadmap)
        return roadmap_message(roadmap, time_ns)

    def put_a_zone(daemon: Daemon, now: RunState) -> bool:
        if daemon.roadmap is not None and not daemon.zones.revision:
            for zone in (
                desk,
                {**desk, "name": "mine", "circle": (2.0, 1.5, 0.2), "robots": ["b"]},
            ):
                if "robots" not in zone or "b" in daemon.robots:
                    daemon.zones.put(ZoneSection.model_validate(zone))
        return now.time_s > 2.0

    place = (1.2, 0.9)
    desk = {"name": "desk", "kind": "keep_out", "circle": (*place, 0.2)}
    monkeypatch.setattr(files.messages, "roadmap_message", draw)
    run_virtually(config, look=put_a_zone, record=tmp_path)
    near = [
        min(
            math.dist(point, place)
            for *_, data in roadmap.graph.edges(data=True)
            for point in data["polyline"]
        )
        for roadmap in drawn
    ]
    assert near[0] < 0.2 <= near[-1] - drawn[-1].radius + 1e-6
    assert len(drawn[-1].scene.objects) == len(drawn[0].scene.objects) + 1, "b's own zone is none"


def test_the_recorded_configuration_needs_no_mask_s_file(tmp_path: Path) -> None:
    write_mask(tmp_path)
    text = GOOD + "zones: [{name: old, kind: keep_out, mask: mask.yaml}]\n"
    config = parse_config(text, "run.yaml", tmp_path)
    assert "zones" not in configuration_body(config, "", "1", 1, 0.0, 0)["config"]


def test_a_plan_by_zones_comes_out_the_same_in_a_replay(tmp_path: Path) -> None:
    """The zones are changed between two plans of one scene: each is planned by its own."""
    goal, at = (2.2, 1.6, 0.0), (1.0, 1.6)
    across = Zone("across", "keep_out", CircleArea(at, 0.2))

    def each(bench: RecordedBench) -> None:
        bench.frames(3)
        bench.plan(1, goal)
        bench.revision += 1
        scene = bench.planner.roadmap
        assert scene is not None
        bench.planner.see(scene.scene, bench.revision, (across,))
        bench.recorder.zones((across,), bench.revision, bench.now_s)
        bench.plan(2, goal)
        bench.frames(3)

    (file,) = make_recording(tmp_path, each, **EVERY)
    recording = read_recording(file)
    first, second = (plan.answer["path"] for plan in recording.plans)
    near = [min(math.dist(place, at) for place in path) for path in (first, second)]
    assert near[0] < 0.2 < near[1], "the zone lies on the first path"
    result = replay(recording)
    assert (result.plans, result.not_compared, result.differences) == (2, 0, [])
