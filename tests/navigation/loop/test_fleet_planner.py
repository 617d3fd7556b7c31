"""The planner of several robots: in which order each of them visits its stations."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator
from itertools import pairwise, permutations
from pathlib import Path

import pytest

from navigation.config import limits_of, load_config
from navigation.config.several.each_robot import each_robot
from navigation.fleet.request import Driving, FleetAnswer, FleetRequest, Traveller
from navigation.loop.planner_news import PlannerNews
from navigation.loop.planning import PlannerThread, SceneCheck
from navigation.loop.traffic.fleet_planner import FleetPlanner
from navigation.mission.cycle import PlanRequest
from navigation.mission.mission import Station
from planner.formats.scene_io import read_scene_text
from planner.path import NoPath
from planner.scene import Bounds
from planner.zones.areas import CircleArea
from planner.zones.zone import Zone
from tests.support.robots.obedient_fleet import HALL
from tests.support.waiting import wait_until

CONFIG = load_config(Path(__file__).parents[3] / "configs" / "fleet.yaml", {})
STATIONS = (Station(2.0, 0.4), Station(0.5, 0.4), Station(1.2, 0.4), Station(2.2, 0.4))
START = (0.2, 0.4, 0.0)


def answer(open_order: tuple[Station, ...], first: Station) -> FleetAnswer:
    alone = {name: one for name, one in each_robot(CONFIG).items() if name in ("ada", "bob")}
    fleet = FleetPlanner(alone)
    fleet.see(read_scene_text(HALL, "hall").with_bounds(Bounds(0.0, 0.0, 2.4, 1.8)), 1)
    limits = limits_of(alone["ada"])
    travellers = (
        Traveller("ada", START, first, 0.07, limits, open_order),
        Traveller("bob", (1.2, 1.2, 0.0), Station(1.2, 1.6), 0.07, limits),
    )
    return fleet.answer(FleetRequest(1, 1, travellers))


def test_a_robot_whose_order_is_open_goes_to_the_nearest_first_and_is_told_the_order() -> None:
    ada = answer(STATIONS, STATIONS[0]).promises["ada"]
    *vias, goal = STATIONS

    def length_m(order: tuple[int, ...]) -> float:
        places = [START[:2], *((vias[i].x, vias[i].y) for i in order), (goal.x, goal.y)]
        return sum(math.dist(a, b) for a, b in pairwise(places))

    assert ada.path.order == min(permutations(range(3)), key=length_m)
    assert ada.station == STATIONS[ada.path.order[0]]


@pytest.mark.parametrize("open_order", [(), STATIONS[:1], STATIONS[:2]])
def test_where_nothing_is_to_choose_the_stations_stay_as_written(
    open_order: tuple[Station, ...],
) -> None:
    ada = answer(open_order, STATIONS[0]).promises["ada"]
    assert ada.station == STATIONS[0]
    assert ada.path.order == tuple(range(max(len(open_order) - 1, 0)))


def test_a_station_without_a_path_leaves_the_order_as_written() -> None:
    """It is refused when its turn comes, as in a mission whose order is fixed."""
    unreachable = (STATIONS[0], Station(0.01, 0.01), STATIONS[2], STATIONS[3])
    ada = answer(unreachable, STATIONS[0]).promises["ada"]
    assert (ada.station, ada.path.order) == (STATIONS[0], (0, 1, 2))


def test_a_preview_asked_while_a_zone_is_taken_over_leaves_the_next_one_with_the_zone() -> None:
    fleet = FleetPlanner(each_robot(CONFIG))
    scene = read_scene_text(HALL, "hall").with_bounds(Bounds(0.0, 0.0, 2.4, 1.8))
    request = PlanRequest(0, START, STATIONS[:1], 0)
    desk = Zone("desk", "keep_out", CircleArea((2.0, 0.4), 0.1))

    class Asked(tuple[Zone, ...]):
        """Zones in whose midst another thread asks: when they are read."""

        def __iter__(self) -> Iterator[Zone]:
            fleet.preview("ada", request)
            return super().__iter__()

    fleet.see(scene, 1)
    fleet.see(scene, 2, Asked([desk]))
    path = fleet.preview("ada", request).path
    assert isinstance(path, NoPath)
    assert "keep-out zone 'desk'" in path.reason


class Searching(FleetPlanner):
    """Planner whose first search ends when `may_end` is set."""

    def __init__(self) -> None:
        super().__init__(each_robot(CONFIG))
        self.begun, self.may_end = threading.Event(), threading.Event()

    def answer(self, request: FleetRequest) -> FleetAnswer:
        if request.id == 1:
            self.begun.set()
            assert self.may_end.wait(30.0)
        return super().answer(request)


class Searched:
    """Its thread, and what comes of it; ``ada`` asks beside ``bob``, who drives."""

    def __init__(self) -> None:
        self.planner = Searching()
        self.checks: list[SceneCheck] = []
        self.news = PlannerNews(self.planner, time.monotonic, lambda: None, None)
        self.answers: list[FleetAnswer] = []
        self.thread = PlannerThread(self.planner, self.checks.append, self.on_answer)
        self.hall = read_scene_text(HALL, "hall").with_bounds(Bounds(0.0, 0.0, 2.4, 1.8))
        limits = limits_of(each_robot(CONFIG)["ada"])
        self.ada = Traveller("ada", START, STATIONS[0], 0.07, limits)
        self.bob = Driving(answer((), STATIONS[0]).promises["bob"], 0, 0, limits)

    def on_answer(self, one: FleetAnswer) -> None:
        self.answers.append(one)
        self.news.on_answer(one)

    def __enter__(self) -> Searched:
        self.thread.start()
        self.sees(1)
        return self

    def __exit__(self, *_error: object) -> None:
        self.planner.may_end.set()
        self.thread.stop()

    def sees(self, revision: int) -> None:
        """Wait until a scene is checked."""
        self.thread.see(self.hall, revision, None)
        assert wait_until(lambda: bool(self.checks) and self.checks[-1].revision == revision, 30.0)


@pytest.mark.parametrize("others_join", [True, False])
def test_while_robots_drive_a_new_scene_is_checked_before_a_search_ends(
    *, others_join: bool
) -> None:
    """An obstacle in a driving robot's path was known only once the path of another was found.

    In the midst of a plan of all robots drive where all held, and asked again.
    """
    with Searched() as one:
        driving = (one.bob,) if others_join else ()
        one.thread.ask(FleetRequest(1, 1, (one.ada,), driving=driving))
        assert one.planner.begun.wait(30.0)
        one.sees(2)
        assert not one.answers
        one.planner.may_end.set()
        assert wait_until(lambda: bool(one.answers), 30.0)
        assert one.answers[0].scene_revision == 2
        assert one.answers[0].promises.keys() == {"ada"}


def test_the_answer_that_the_loop_finds_is_the_newest_request_s() -> None:
    """The answer to a withdrawn request arrived later and replaced it: no robot got a path."""
    with Searched() as one:
        one.thread.ask(FleetRequest(1, 1, (one.ada,), driving=(one.bob,)))
        assert one.planner.begun.wait(30.0)
        one.thread.ask(FleetRequest(2, 1, (one.ada,)))
        one.sees(2)
        one.sees(3)  # whatever the thread of the scenes took before has been answered
        one.planner.may_end.set()
        assert wait_until(lambda: len(one.answers) == 2, 30.0)
        _checks, found = one.news.take()
        assert isinstance(found, FleetAnswer)
        assert found.id == 2
