"""The planner of several robots: in which order each of them visits its stations."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from itertools import pairwise, permutations
from pathlib import Path

import pytest

from navigation.config import limits_of, load_config
from navigation.config.several.each_robot import each_robot
from navigation.fleet.request import Driving, FleetAnswer, FleetRequest, Traveller
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


def test_while_robots_drive_a_new_scene_is_checked_before_a_search_for_others_ends() -> None:
    """An obstacle in a driving robot's path was known only once the path of another was found."""
    begun, may_end = threading.Event(), threading.Event()
    checks: list[SceneCheck] = []
    answers: list[FleetAnswer] = []

    class Searching(FleetPlanner):
        def answer(self, request: FleetRequest) -> FleetAnswer:
            begun.set()
            assert may_end.wait(30.0)
            return super().answer(request)

    hall = read_scene_text(HALL, "hall").with_bounds(Bounds(0.0, 0.0, 2.4, 1.8))
    promise = answer((), STATIONS[0]).promises["bob"]
    limits = limits_of(each_robot(CONFIG)["ada"])
    thread = PlannerThread(Searching(each_robot(CONFIG)), checks.append, answers.append)
    thread.start()
    thread.see(hall, 1, None)
    ada = Traveller("ada", START, STATIONS[0], 0.07, limits)
    try:
        assert wait_until(lambda: len(checks) == 1, 30.0)
        thread.ask(FleetRequest(1, 1, (ada,), driving=(Driving(promise, 0, 0, limits),)))
        assert begun.wait(30.0)
        thread.see(hall, 2, None)
        assert wait_until(lambda: [one.revision for one in checks] == [1, 2], 30.0)
        assert not answers
        may_end.set()
        assert wait_until(lambda: bool(answers), 30.0)
        assert answers[0].scene_revision == 2
        assert answers[0].promises.keys() == {"ada"}
    finally:
        may_end.set()
        thread.stop()
