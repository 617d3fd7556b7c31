"""What viewers are told: packed arrays, the arena's geometry, pictures, state, log, metrics."""

import json
import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.host.state import LinkState
from navigation.dashboard.admission.seat import Seat
from navigation.dashboard.messages.chronicle import COLUMNS, Chronicle
from navigation.dashboard.messages.geometry import plan_message, world_message
from navigation.dashboard.messages.packed import pack
from navigation.dashboard.messages.palette import DAY, NIGHT, stylesheet
from navigation.dashboard.messages.picture import TopView
from navigation.dashboard.messages.rings import Ring
from navigation.dashboard.messages.state_message import preview_facts, state_message
from navigation.draw.shapes import CLEARANCE_RAMP, OBSTACLE, PAGE, PATH
from navigation.link.link_snapshot import LinkSnapshot
from navigation.loop.run_state import StageTimes
from navigation.mission.cycle import PlanAnswer
from navigation.mission.mission import MissionProgress, State, Station
from navigation.mission.trust import Level
from planner.path import Bottleneck, NoPath, Path
from planner.roadmap.roadmap import Roadmap
from planner.scene import Bounds
from planner.zones.areas import CircleArea
from planner.zones.zone import Zone
from planner.zones.zoned_roadmap import with_zones
from tests.navigation.dashboard.contrast import contrast
from tests.planner.zones.plain_geometry import dense, distances
from tests.support.runs.packed import unpack
from tests.support.runs.shown import RADIUS_M, SCALE_M, SIZE_PX, FakeDaemon, frame, laboratory
from vision.calibration.calibration import Calibration
from vision.markers.markers import RobotPose

ARENA = Bounds(0.0, 0.0, 2.4, 1.8)


@pytest.fixture(scope="module")
def roadmap() -> Roadmap:
    return laboratory()


# Packed arrays.


@given(
    st.lists(st.integers(0, 255), max_size=9),
    st.lists(st.floats(width=32, allow_nan=False), max_size=9),
    st.text(max_size=9),
)
def test_what_is_packed_comes_out_unchanged(
    octets: list[int], floats: list[float], words: str
) -> None:
    arrays = {
        "octets": np.array(octets, dtype=np.uint8),
        "floats": np.array(floats, dtype=np.float32),
        "none": np.empty(0, dtype=np.int32),
    }
    head, found = unpack(pack("kind", {"words": words}, arrays))
    assert head == {"type": "kind", "words": words}
    for name, array in arrays.items():
        np.testing.assert_array_equal(found[name], array)
        assert found[name].dtype == array.dtype


def test_every_array_lies_where_a_browser_can_look_into_it_without_copying() -> None:
    message = pack("k", {"a": "ä"}, {"one": np.zeros(3, np.uint8), "two": np.zeros(2, np.int32)})
    length = int.from_bytes(message[:4], "little")
    assert length % 4 == 0
    index = json.loads(message[4 : 4 + length])["arrays"]
    assert all(first % 4 == 0 for _, first, _ in index.values())


# Rings.


@given(st.integers(1, 8), st.integers(0, 30), st.integers(0, 40), st.integers(1, 9))
def test_a_ring_gives_the_newest_items_with_their_numbers(
    size: int, count: int, asked: int, most: int
) -> None:
    ring: Ring[int] = Ring(size)
    for number in range(count):
        ring.append(number)
    first, items = ring.since(asked, most)
    assert items == list(range(max(asked, count - size, 0), count))[:most]
    assert not items or first == items[0]
    assert ring.last == (count - 1 if count else None)


# Geometry.


def test_the_world_has_every_border_of_the_scene(roadmap: Roadmap) -> None:
    head, arrays = unpack(world_message(with_zones(roadmap, ()), 3))
    assert (head["number"], head["objects"]) == (3, 7)
    first = arrays["border_first"]
    assert len(first) == len(arrays["border_closed"]) + 1 == len(arrays["border_object"]) + 1
    assert set(arrays["border_object"]) == set(range(7))
    assert arrays["border_closed"].all()
    points = arrays["border"].reshape(-1, 2)
    assert first[-1] == len(points)
    # the bucket of the arena's file: C (0.42,1.16) 0.13
    away = np.hypot(*(points - (0.42, 1.16)).T)
    ring = [points[a:b] for a, b in pairwise(first) if np.ptp(away[a:b]) < 1e-5]
    assert len(ring) == 1
    np.testing.assert_allclose(np.hypot(*(ring[0] - (0.42, 1.16)).T), 0.13, atol=1e-6)


def test_the_diagrams_clearances_are_those_of_its_places(roadmap: Roadmap) -> None:
    _, arrays = unpack(world_message(with_zones(roadmap, ()), 1))
    points = arrays["chain"].reshape(-1, 2)
    told = arrays["chain_clearance"]
    np.testing.assert_allclose(roadmap.clearance(points), told, atol=1e-5)


def test_what_is_told_to_be_usable_is_the_roadmap(roadmap: Roadmap) -> None:
    _, arrays = unpack(world_message(with_zones(roadmap, ()), 1))
    first, usable = arrays["chain_first"], arrays["chain_usable"].astype(bool)
    for c in np.flatnonzero(usable):
        assert (arrays["chain_clearance"][first[c] : first[c + 1]] >= RADIUS_M - 1e-6).all()
    points = arrays["chain"].reshape(-1, 2).astype(np.float64)
    pieces = [points[first[c] : first[c + 1]] for c in np.flatnonzero(usable)]
    told_m = sum(np.hypot(*np.diff(piece, axis=0).T).sum() for piece in pieces)
    whole_m = sum(length for _, _, length in roadmap.graph.edges(data="length"))
    # the graph's edges follow their bisectors more closely than the chains' points do
    assert whole_m * (1.0 - 1e-3) <= told_m <= whole_m + 1e-6
    assert not usable.all(), "the arena has places that are too tight"


def test_the_roadmap_keeps_off_a_keep_out_zone_and_its_colours_are_the_clearance_to_walls(
    roadmap: Roadmap,
) -> None:
    closing, beside = CircleArea((1.2, 0.9), 0.15), CircleArea((0.3, 0.3), 0.15)
    zones = Zone("desk", "keep_out", closing), Zone("bend", "slow", beside, speed=0.1)
    head, arrays = unpack(world_message(with_zones(roadmap, zones), 1))
    assert head["objects"] == 7, "a zone is no obstacle"
    assert set(arrays["border_object"]) == set(range(7))
    points, first = arrays["chain"].reshape(-1, 2), arrays["chain_first"]
    np.testing.assert_allclose(roadmap.clearance(points), arrays["chain_clearance"], atol=1e-5)
    usable = np.flatnonzero(arrays["chain_usable"])
    lines = [dense(points[first[c] : first[c + 1]]) for c in usable]
    on_roadmap = np.concatenate(lines)
    assert distances(closing, on_roadmap).min() >= RADIUS_M - 1e-3
    assert distances(beside, on_roadmap).min() < 0.0, "only keep-out zones close the roadmap"


def test_the_plan_is_told_with_its_length_and_clearance(roadmap: Roadmap) -> None:
    path = roadmap.plan((0.2, 0.2), (2.2, 1.6))
    assert isinstance(path, Path)
    head, arrays = unpack(plan_message(path, 2))
    points = arrays["points"].reshape(-1, 2)
    np.testing.assert_allclose(points, path.points, atol=1e-6)
    assert head["length_m"] == pytest.approx(np.hypot(*np.diff(points, axis=0).T).sum(), abs=1e-4)
    assert head["clearance_m"] >= head["radius_m"] == RADIUS_M
    head, arrays = unpack(plan_message(None, 3))
    assert (head["number"], len(arrays["points"])) == (3, 0)


def test_a_preview_says_the_way_or_why_there_is_none() -> None:
    daemon = FakeDaemon(roadmap=laboratory())
    told = preview_facts(daemon.people.preview((Station(2.2, 1.6),)))
    assert told["ok"]
    assert told["points"][0] == [0.2, 0.2]
    assert told["duration_s"] > told["length_m"] / 0.3
    told = preview_facts(daemon.people.preview((Station(0.42, 1.16),)))
    assert not told["ok"]
    assert told["reason"]
    gap = PlanAnswer(1, 1, NoPath("too tight", Bottleneck(1.0, 2.0, 0.1), 0.05))
    told = preview_facts(gap)
    assert told["bottleneck"] == {"x_m": 1.0, "y_m": 2.0, "width_m": 0.1}
    assert told["widest_radius_m"] == 0.05


def test_what_the_planner_remarks_is_told_with_plan_preview_and_refusal(roadmap: Roadmap) -> None:
    path = roadmap.plan((0.2, 0.2), (2.2, 1.6))
    assert isinstance(path, Path)
    remarked = replace(path, remarks=("the margin is given up",))
    head, _ = unpack(plan_message(remarked, 2))
    assert head["remarks"] == ["the margin is given up"]
    assert preview_facts(PlanAnswer(1, 1, remarked))["remarks"] == ["the margin is given up"]
    refused = NoPath("too tight", remarks=("the search was cut short",))
    assert preview_facts(PlanAnswer(1, 1, refused))["remarks"] == ["the search was cut short"]


# Pictures.


def test_the_view_from_above_shows_each_place_where_the_page_looks_for_it() -> None:
    view = TopView(Calibration.from_scale(SCALE_M, SIZE_PX), ARENA, 480, 100)
    picture = cv2.imdecode(view.jpegs(frame(1), (480,))[480], cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    assert picture.shape[::-1] == view.size_px
    scale = view.metres_per_pixel

    def grey(x_m: float, y_m: float) -> int:
        column = int((x_m - view.window.x_min) / scale)
        row = int((view.window.y_max - y_m) / scale)
        return int(picture[row, column])

    assert grey(0.05, 0.05) > 230, "the bright square at the origin"
    assert grey(0.15, 0.15) < 70
    assert grey(2.30, 1.00) > 180
    assert grey(view.window.x_min + scale, 1.0) == pytest.approx(128, abs=6), "beyond the picture"


def test_a_camera_that_gives_another_size_is_scaled() -> None:
    view = TopView(Calibration.from_scale(SCALE_M, SIZE_PX), ARENA, 240, 80)
    small = frame(1)
    half = replace(small, image=np.asarray(small.image[::2, ::2]))
    assert cv2.imdecode(view.jpegs(half, (240,))[240], cv2.IMREAD_GRAYSCALE) is not None


# State.


def told_state(daemon: FakeDaemon, *others: RobotPose) -> dict[str, object]:
    assert daemon.robot is not None
    return state_message(
        daemon.robot,
        TopView(daemon.calibration, ARENA, 160, 80),
        daemon.camera,
        Seat(300.0),
        others=others,
        now_s=0.05,
        loop_age_s=0.01,
        viewers=2,
    )


def stop_doubt(state: State, link: LinkSnapshot) -> object:
    daemon = FakeDaemon()
    assert daemon.robot is not None
    daemon.robot = replace(daemon.robot, mission=MissionProgress(state=state), link=link)
    told = told_state(daemon)["link"]
    assert isinstance(told, dict)
    return told["stop_doubt"]


def test_the_page_calls_wheels_off_only_when_the_robot_is_known_to_stand() -> None:
    stands = LinkSnapshot(LinkState.STREAM, None, 0.02, status_age_s=0.05, estopped=True)
    assert stop_doubt(State.STOPPED, stands) is None
    assert "not been heard to stand" in str(stop_doubt(State.STOPPED, replace(stands, moving=True)))
    unheard = replace(stands, down_reason="the driver has ended", stands=False)
    assert "the driver has ended" in str(stop_doubt(State.STOPPED, unheard))
    assert stop_doubt(State.DRIVING, replace(stands, estopped=False)) is None


def test_a_state_without_anything_seen_is_still_json() -> None:
    daemon = FakeDaemon()
    assert daemon.robot is not None
    link = replace(daemon.robot.link, heard_age_s=math.inf, status_age_s=math.inf)
    daemon.show(pose=None, poses={}, link=link, clearance_m=None)
    text = json.dumps(told_state(daemon), allow_nan=False)
    assert json.loads(text)["link"]["heard_ms"] is None


def test_the_state_says_where_the_robots_are_and_why_nothing_moves() -> None:
    daemon = FakeDaemon()
    assert daemon.robot is not None
    assert daemon.robot.pose is not None
    other = replace(daemon.robot.pose, id=3, x=1.0)
    mission = MissionProgress((Station(1.0, 1.0),), 0, state=State.HOLDING, reason="because")
    daemon.show(mission=mission)
    told = told_state(daemon, other)
    assert [one["id"] for one in told["others"]] == [3]  # type: ignore[attr-defined]
    pose = told["pose"]
    assert isinstance(pose, dict)
    assert pose["seen_m"] == pytest.approx([0.2, 0.2], abs=1e-3)
    assert pose["age_ms"] == 50.0
    assert told["mission"]["sentence"] == "because"  # type: ignore[index]


# The chronicle.


def seen(*sentences: str) -> Iterator[str]:
    daemon, chronicle = FakeDaemon(), Chronicle(0.3)
    assert daemon.robot is not None
    for sentence in sentences:
        mission = MissionProgress(state=State.HOLDING, reason=sentence)
        now = replace(daemon.robot, mission=mission, sentence=sentence)
        chronicle.see_robot(now, 0.0)
    return (line.text for line in chronicle.log.since(0, 99)[1])


def test_a_sentence_whose_figures_alone_change_is_one_line_in_the_log() -> None:
    told = list(seen("no picture for 210 ms", "no picture for 243.5 ms", "paused", "no picture"))
    assert told == ["holding: no picture for 210 ms", "holding: paused", "holding: no picture"]


def test_the_track_grows_with_the_robots_way_not_with_time() -> None:
    daemon, chronicle = FakeDaemon(), Chronicle(0.3)
    assert daemon.robot is not None
    assert daemon.robot.pose is not None
    for step in range(1000):
        there = replace(daemon.robot.pose, x=0.2 + 0.0001 * (step // 2))
        chronicle.see_robot(replace(daemon.robot, pose=there), 0.0)
    assert 10 <= len(chronicle.track.since(0, 999)[1]) <= 14


def test_the_track_breaks_where_the_robot_was_carried_and_holds_nothing_of_it() -> None:
    daemon, chronicle = FakeDaemon(), Chronicle(0.3)
    assert daemon.robot is not None
    pose = daemon.robot.pose
    assert pose is not None
    for step in range(90):
        carried = 30 <= step < 60
        there = replace(pose, captured_s=step / 30.0, x=0.2 + 0.01 * step, y=0.3)
        trust = Level.DOUBTED if carried else Level.SURE
        chronicle.see_robot(replace(daemon.robot, pose=there, trust=trust), 0.0)
    _, places = chronicle.track.since(0, 999)
    assert [place for place in places if place is None] == [None]
    assert not any(place and 0.5 <= place[0] < 0.79 for place in places)


def test_a_sample_has_every_column_twice_a_second() -> None:
    daemon, chronicle = FakeDaemon(), Chronicle(0.3)
    assert daemon.robot is not None
    for cycle in range(100):
        times = StageTimes(wire_s=0.001 * cycle)
        now = replace(daemon.robot, time_s=cycle * 0.03, times=times)
        chronicle.sample(now, daemon.camera)
    _, rows = chronicle.samples.since(0, 99)
    assert len(rows) == 6
    assert all(len(row) == len(COLUMNS) for row in rows)
    wire = COLUMNS.index("wire_ms")
    assert rows[1][wire] == pytest.approx(17.0), "the slowest of its half second"


# Colours.


@pytest.mark.parametrize("palette", [DAY, NIGHT], ids=["day", "night"])
def test_every_ink_can_be_read_on_every_surface(palette: dict[str, tuple[int, int, int]]) -> None:
    """WCAG 2.2 AA: 4.5 for text, 3 for what frames a control."""
    for ink in ("ink", "faint"):
        for surface in ("page", "card", "calm-tint"):
            assert contrast(palette[ink], palette[surface]) >= 4.5, (ink, surface)
    for level in ("good", "warn", "bad"):
        for surface in ("card", f"{level}-tint"):
            assert contrast(palette[level], palette[surface]) >= 4.5, (level, surface)
    assert contrast(palette["on-stop"], palette["stop"]) >= 4.5
    assert contrast(palette["on-stop"], palette["stop-press"]) >= 4.5
    assert contrast(palette["on-accent"], palette["accent"]) >= 4.5
    for surface in ("page", "card"):
        assert contrast(palette["control-line"], palette[surface]) >= 3.0
        assert contrast(palette["stop"], palette[surface]) >= 3.0
        assert contrast(palette["accent"], palette[surface]) >= 3.0


def test_contrast_is_the_standards() -> None:
    assert contrast((0, 0, 0), (255, 255, 255)) == pytest.approx(21.0)
    assert contrast((255, 255, 255), (255, 255, 255)) == pytest.approx(1.0)
    # #777777 on white, the well-known near miss of AA
    assert contrast((0x77, 0x77, 0x77), (255, 255, 255)) == pytest.approx(4.48, abs=0.005)


def test_the_page_and_the_pictures_share_their_colours() -> None:
    style = stylesheet()
    for name, (r, g, b) in (("obstacle", OBSTACLE), ("path", PATH), ("halo", PAGE)):
        assert f"--{name}: rgb({r} {g} {b});" in style
    assert "--ramp-0: rgb({} {} {});".format(*CLEARANCE_RAMP[0]) in style
    assert "--ramp-23: rgb({} {} {});".format(*CLEARANCE_RAMP[-1]) in style
