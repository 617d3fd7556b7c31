"""Orders that name a robot reach that robot only; those that name none reach all."""

from types import SimpleNamespace

import pytest

from navigation.loop.people import People
from navigation.orders.carry_out import SCHEMA, carry_out
from navigation.orders.table import ORDERS
from tests.support.people import RecordedPeople

ARGUMENTS = {"stations": [{"x_m": 1.0, "y_m": 1.0}], "reason": "now", "camera": "left"}
OF_ROBOTS = [name for name, one in ORDERS.items() if not (one.only_looks or one.command)]


@pytest.mark.parametrize("order", OF_ROBOTS)
def test_an_order_reaches_the_robot_that_it_names(order: str) -> None:
    people = RecordedPeople()
    answer = carry_out({"order": order, "robot": "bob", **ARGUMENTS}, people)
    assert (answer["schema"], answer["ok"], answer["name"]) == (SCHEMA, True, "bob")
    ((_, *given),) = people.orders
    assert given[-1] == "bob"


@pytest.mark.parametrize("order", OF_ROBOTS)
def test_an_order_without_a_name_is_for_all(order: str) -> None:
    people = RecordedPeople()
    answer = carry_out({"order": order, **ARGUMENTS}, people)
    assert "name" not in answer
    ((_, *given),) = people.orders
    assert "bob" not in given


def test_a_stop_is_answered_as_ever() -> None:
    people = RecordedPeople(stop="a restart would not know")
    assert carry_out({"order": "stop", "reason": "now"}, people) == {
        "schema": SCHEMA,
        "ok": True,
        "state": "stopped",
        "reason": "waiting",
        "trouble": "a restart would not know",
    }
    assert people.orders == [("stop", "now")]


ROBOTS = ({"ada": None, "bob": None}, {"": None})
NAMES = ("eve", 7, "", ["ada"], {"name": "ada"}, "ada" * 500)


def given(order: str, name: object, robots: dict[str, None]) -> tuple[str, list[object]]:
    """Error of an order for a robot of that name, and what was stopped."""
    stopping = RecordedPeople()
    people = People(SimpleNamespace(robots=robots, stopping=stopping))
    stopping.stop = lambda robots, reason: stopping.orders.append((len(robots), reason))
    answer = carry_out({"order": order, "robot": name, **ARGUMENTS}, people)
    assert not answer["ok"]
    return answer["error"], stopping.orders


@pytest.mark.parametrize("order", [*OF_ROBOTS, "status"])
@pytest.mark.parametrize("name", NAMES)
def test_a_name_that_is_none_is_refused_and_only_a_stop_is_carried_out_for_all(
    order: str, name: object
) -> None:
    for robots in ROBOTS:
        error, stopped = given(order, name, robots)
        assert error.startswith("robot ")
        assert stopped == ([(len(robots), "now")] if order == "stop" else [])
        assert error.endswith(" stopped") == (order == "stop")


def test_a_stop_with_a_wrong_name_says_what_it_did() -> None:
    assert given("stop", "eve", ROBOTS[0])[0] == (
        "robot 'eve': there are ada, bob; all robots were stopped"
    )
    assert given("stop", "eve", ROBOTS[1])[0] == (
        "robot 'eve': this run has one robot, which has no name; the robot was stopped"
    )


@pytest.mark.parametrize("order", sorted(set(OF_ROBOTS) - {"stop"}))
def test_a_run_with_one_robot_says_that_it_has_no_names(order: str) -> None:
    error, _ = given(order, "ada", ROBOTS[1])
    assert error == "robot 'ada': this run has one robot, which has no name"
