"""What the page of several robots is told and may order, without a browser."""

import asyncio
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from navigation.config import load_config
from navigation.dashboard.chronicles import Chronicles
from navigation.dashboard.hub import Hub
from navigation.dashboard.messages.geometry import plans_message
from navigation.dashboard.orders import give
from navigation.loop.daemon import Daemon
from navigation.mission.mission import MissionError, State, Station
from navigation.run.virtual_world import VirtualWorld
from tests.support.runs.packed import unpack
from tests.support.runs.shown import laboratory

ALCOVE = load_config(Path(__file__).parents[4] / "configs" / "alcove.yaml", {})
A, B = (one.name for one in ALCOVE.robots)


@pytest.fixture(scope="module")
def fleet() -> Iterator[Daemon]:
    """Two robots that were seen, in virtual time and without missions."""
    with Daemon(ALCOVE, VirtualWorld(ALCOVE), first_mission_id=1) as daemon:
        run(daemon, 1.0)
        yield daemon


def run(daemon: Daemon, seconds: float) -> None:
    end_s = daemon.world.clock() + seconds
    while daemon.world.clock() < end_s:
        daemon.cycle()


def hub_of(daemon: Daemon) -> Hub:
    async def look() -> Hub:
        hub = Hub(daemon, clock=daemon.world.clock, wall_clock=lambda: 0.0)
        hub.look(daemon.world.clock())
        return hub

    return asyncio.run(look())


def stopped(daemon: Daemon) -> set[str]:
    run(daemon, 0.5)
    return {
        name for name, seat in daemon.robots.items() if seat.pilot.mission.state is State.STOPPED
    }


def test_the_greeting_and_the_state_name_every_robot_with_its_own_place(fleet: Daemon) -> None:
    hub = hub_of(fleet)
    assert [one["name"] for one in hub.hello["robots"]] == [A, B]
    assert [one["marker_id"] for one in hub.hello["robots"]] == [
        one.marker_id for one in ALCOVE.robots
    ]
    state = hub.state_now()
    assert state is not None
    for one in state["robots"]:
        pose = fleet.robots[one["name"]].pose
        assert pose is not None
        assert one["pose"]["id"] == fleet.robots[one["name"]].config.robot.marker_id
        assert one["pose"]["x_m"] == pytest.approx(pose.x, abs=1e-4)
        assert one["link"]["reason"] is None
    assert state["others"] == []  # its own robots are no strangers
    assert state["pose"] is None


def test_the_summary_takes_the_link_that_needs_looking_after(fleet: Daemon) -> None:
    assert fleet.state is not None
    robots = dict(fleet.state.robots)
    assert fleet.state.together.link.down_reason is None
    robots[B] = replace(robots[B], link=replace(robots[B].link, down_reason="cable out"))
    assert replace(fleet.state, robots=robots).together.link.down_reason == "cable out"


def test_plans_are_told_apart_by_where_each_begins() -> None:
    road = laboratory()
    path = road.plan((0.2, 0.2), (2.2, 1.6))
    assert path
    head, arrays = unpack(plans_message({"a": path, "b": None, "c": path}, 4))
    n = len(path.points)
    assert [one["name"] for one in head["plans"]] == ["a", "b", "c"]
    assert arrays["first"].tolist() == [0, n, n, 2 * n]
    np.testing.assert_allclose(arrays["points"].reshape(-1, 2)[n:], path.points, atol=1e-6)
    assert "length_m" not in head["plans"][1]


def test_a_stop_is_for_all_or_for_the_one_that_is_named_and_only_rearming_leaves_it(
    fleet: Daemon,
) -> None:
    people = fleet.people
    assert give({"order": "stop", "robot": A}, people, "somebody")["ok"]
    assert stopped(fleet) == {A}
    assert not give({"order": "resume", "robot": A}, people, "somebody")["ok"]
    assert not give({"order": "rearm", "robot": B}, people, "somebody")["ok"]
    assert give({"order": "resume"}, people, "somebody")["ok"]  # of those that are not stopped
    assert stopped(fleet) == {A}
    assert give({"order": "stop"}, people, "somebody")["ok"]
    assert stopped(fleet) == {A, B}
    refused = give({"order": "go", "robot": B, "stations": [{"x_m": 1.0, "y_m": 0.5}]}, people, "x")
    assert "re-arm" in refused["error"]
    assert give({"order": "rearm", "robot": B}, people, "somebody")["ok"]
    assert stopped(fleet) == {A}
    assert give({"order": "rearm"}, people, "somebody")["ok"]
    assert stopped(fleet) == set()
    assert "nothing to rearm" in give({"order": "rearm"}, people, "somebody")["error"]


def test_an_order_that_names_nobody_or_somebody_unknown_is_refused_in_words(
    fleet: Daemon,
) -> None:
    go = {"order": "go", "stations": [{"x_m": 1.0, "y_m": 0.5}]}
    assert "say which one" in give(go, fleet.people, "x")["error"]
    assert "there are" in give({**go, "robot": "nobody"}, fleet.people, "x")["error"]
    assert "there are" in give({**go, "robot": 3}, fleet.people, "x")["error"]


def test_a_preview_is_of_the_named_robot_from_where_it_stands(fleet: Daemon) -> None:
    people = fleet.people
    pose = fleet.robots[B].pose
    assert pose is not None
    answer = people.preview((Station(pose.x, pose.y),), B)
    assert answer.path
    with pytest.raises(MissionError, match="say which one"):
        people.preview((Station(1.0, 0.5),))
    with pytest.raises(MissionError, match="there are"):
        people.preview((Station(1.0, 0.5),), "nobody")


def test_each_robot_has_its_own_charts_and_its_name_before_its_lines_in_one_log(
    fleet: Daemon,
) -> None:
    assert fleet.state is not None
    chronicles = Chronicles(ALCOVE)
    chronicles.see(fleet.state, fleet.camera_status(), 0.0)
    told = [line.text for line in chronicles.all.log.since(0, 99)[1]]
    assert sum(text.startswith(f"{A}: ") for text in told) == 1
    assert sum(text.startswith(f"{B}: ") for text in told) == 1
    assert [name for name, _ in chronicles.rings()] == [A, B]
    for _, chronicle in chronicles.rings():
        assert chronicle.samples.next == 1
