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


@pytest.mark.parametrize("order", [*OF_ROBOTS, "status"])
@pytest.mark.parametrize("name", ["eve", 7, "", ["ada"]])
def test_a_name_that_is_none_is_refused_and_nothing_is_ordered(order: str, name: object) -> None:
    stopping = RecordedPeople()
    people = People(SimpleNamespace(robots={"ada": None, "bob": None}, stopping=stopping))
    answer = carry_out({"order": order, "robot": name, **ARGUMENTS}, people)
    assert not answer["ok"]
    assert "robot" in answer["error"]
    assert stopping.orders == []


@pytest.mark.parametrize("order", OF_ROBOTS)
def test_a_run_with_one_robot_says_that_it_has_no_names(order: str) -> None:
    people = People(SimpleNamespace(robots={"": None}, stopping=RecordedPeople()))
    answer = carry_out({"order": order, "robot": "ada", **ARGUMENTS}, people)
    assert answer["error"] == "robot 'ada': this run has one robot, which has no name"
