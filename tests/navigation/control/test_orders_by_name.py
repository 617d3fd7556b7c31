"""Orders that name a robot reach that robot only; those that name none reach all."""

from collections.abc import Mapping
from typing import Any

import pytest

from navigation.control import carry_out
from navigation.control.orders import SCHEMA
from navigation.mission.mission import MissionError, Station


class Robot:
    """Notes what it is ordered."""

    def __init__(self, name: str) -> None:
        self.name, self.orders = name, list[str]()

    def give(self, stations: tuple[Station, ...]) -> None:
        self.orders.append(f"go {len(stations)}")

    def stop(self, reason: str) -> None:
        self.orders.append(f"stop {reason}")

    def pause(self) -> None:
        self.orders.append("pause")

    def resume(self) -> None:
        self.orders.append("resume")

    def replan(self) -> None:
        self.orders.append("replan")

    def settle(self) -> None:
        """Nothing to wait for."""

    def describe(self) -> Mapping[str, Any]:
        return {"name": self.name}


class Fleet(Robot):
    """All robots together."""

    def __init__(self) -> None:
        super().__init__("all")
        self.robots = {name: Robot(name) for name in ("ada", "bob")}

    def of(self, robot: str) -> Robot:
        if robot not in self.robots:
            raise MissionError(f"robot '{robot}': there are {', '.join(self.robots)}")
        return self.robots[robot]


@pytest.mark.parametrize("order", ["pause", "resume", "replan"])
def test_an_order_reaches_the_robot_that_it_names(order: str) -> None:
    fleet = Fleet()
    answer = carry_out({"order": order, "robot": "bob"}, fleet)
    assert answer == {"schema": SCHEMA, "ok": True, "name": "bob"}
    assert (fleet.orders, fleet.robots["ada"].orders) == ([], [])
    assert fleet.robots["bob"].orders == [order]


def test_a_stop_without_a_name_is_for_all() -> None:
    fleet = Fleet()
    assert carry_out({"order": "stop", "reason": "now"}, fleet) == {
        "schema": SCHEMA,
        "ok": True,
        "name": "all",
    }
    assert fleet.orders == ["stop now"]


def test_a_mission_goes_to_the_robot_that_is_named() -> None:
    fleet = Fleet()
    request = {"order": "go", "robot": "ada", "stations": [{"x_m": 1.0, "y_m": 1.0}]}
    assert carry_out(request, fleet)["ok"]
    assert fleet.robots["ada"].orders == ["go 1"]


@pytest.mark.parametrize("name", ["eve", 7, "", ["ada"]])
def test_a_name_that_is_none_is_refused_and_nothing_is_ordered(name: object) -> None:
    fleet = Fleet()
    answer = carry_out({"order": "stop", "robot": name}, fleet)
    assert not answer["ok"]
    assert "robot" in answer["error"]
    assert not any(robot.orders for robot in (fleet, *fleet.robots.values()))


def test_a_run_with_one_robot_says_that_it_has_no_names() -> None:
    answer = carry_out({"order": "pause", "robot": "ada"}, Robot("only"))
    assert answer["error"] == "robot 'ada': this run has one robot, which has no name"
