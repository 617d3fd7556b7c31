"""The settings of several robots: each a section with fields of its own, saved at rest only."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from navigation.config.load import load_config
from navigation.config.several.each_robot import each_robot
from navigation.dashboard.settings.desk import RefusedError
from navigation.mission.mission import State
from tests.navigation.dashboard.kept.test_settings import Office, post
from tests.navigation.dashboard.site import KEY, Site
from tests.support.runs.shown import FakeDaemon, laboratory

NAMES = ["ada", "bob", "cleo", "dan", "eve", "finn"]
FASTER = {"robots[1].speed_m_s": "0.2"}


@pytest.fixture
def office(tmp_path: Path) -> Office:
    return Office(tmp_path, "fleet.yaml")


@pytest.fixture
def site(office: Office) -> Iterator[Site]:
    with Site(FakeDaemon(roadmap=laboratory()), office.desk) as site:
        yield site


def fields_of(office: Office, name: str) -> dict[str, dict[str, Any]]:
    """A robot's fields by the last word of their keys."""
    (section,) = (s for s in office.desk.show()["sections"] if s["name"] == f"robots: {name}")
    return {field["key"].split(".")[-1]: field for field in section["keys"]}


def test_each_robot_is_a_section_in_the_order_of_the_file(office: Office) -> None:
    titles = [section["name"] for section in office.desk.show()["sections"]]
    begin = titles.index("robot") + 1
    assert titles[begin : begin + 6] == [f"robots: {name}" for name in NAMES]
    assert "robots" not in titles


def test_a_field_shows_its_own_value_and_what_holds_without_it(office: Office) -> None:
    eve, ada = fields_of(office, "eve"), fields_of(office, "ada")
    assert (eve["speed_m_s"]["value"], eve["speed_m_s"]["default"]) == ("0.2", "0.25")
    assert (ada["speed_m_s"]["value"], ada["speed_m_s"]["default"]) == ("", "0.25")
    assert ada["baud"]["default"] == "115200"
    assert ada["track_m"]["default"] == "0.1"
    assert (ada["marker_id"]["value"], ada["marker_id"]["default"]) == ("1", "")
    assert ada["radius_m"]["limits"] == {"above": 0, "most": 100}
    assert ada["port"]["choices"] == ["simulated", "/dev/serial/by-id/usb-b"]


@pytest.mark.parametrize(
    ("key", "typed", "words"),
    [
        ("robots[1].radius_m", "-1", "must be > 0"),
        ("robots[1].speed_m_s", "fast", "must be a number"),
        ("robots[1].marker_id", "", "missing"),
        ("robots[1].marker_id", "1", "already"),
        ("robots[1].port", "/dev/null", "must be one of simulated"),
        ("robots[1].name", "bert", "names are changed in the file"),
        ("robots[6].radius_m", "0.1", "there is no such key"),
        ("robots", "[]", "there is no such key"),
    ],
)
def test_what_is_wrong_is_said_at_the_robot_s_own_field(
    office: Office, key: str, typed: str, words: str
) -> None:
    before = office.file.read_text()
    problems = office.desk.check({key: typed})
    assert any(words in one["sentence"] and one["key"] == key for one in problems), problems
    with pytest.raises(RefusedError, match=words):
        office.desk.save({key: typed}, office.base)
    assert office.file.read_text() == before


def test_a_save_changes_one_robot_and_undo_takes_it_back(office: Office) -> None:
    before = office.file.read_text()
    said = office.desk.save({**FASTER, "robots[4].speed_m_s": ""}, office.base)
    assert said == "saved robots[1].speed_m_s, robots[4].speed_m_s in fleet.yaml"
    speeds = {n: c.robot.speed_m_s for n, c in each_robot(load_config(office.file, {})).items()}
    assert speeds == dict.fromkeys(NAMES, 0.25) | {"bob": 0.2}
    gone = set(before.splitlines()) - set(office.file.read_text().splitlines())
    assert len(gone) == 2, "comments and all other lines stay"
    office.desk.undo()
    assert office.file.read_text() == before
    assert office.reloads == 2


@pytest.mark.parametrize("state", [State.DRIVING, State.STOPPED, State.HOLDING, State.PLANNING])
def test_nothing_is_saved_while_any_one_robot_drives_or_is_stopped(
    site: Site, office: Office, state: State
) -> None:
    """Of all together it may be said that they are at rest: the one has no stations left."""
    states = dict.fromkeys(NAMES, State.DONE)

    def describe() -> dict[str, Any]:
        return {"state": "done", "robots": {n: {"state": s.value} for n, s in states.items()}}

    site.daemon.people.describe = describe  # type: ignore[method-assign]
    with site.live() as page:
        page.join()
        page.send(type="take", id=1)
        page.hear("answer")
        states["dan"] = state
        for address in ("save", "undo"):
            body = {"changes": FASTER, "base": office.base, "key": KEY}
            _, told = post(site, f"/api/settings/{address}", **body)
            assert not told["ok"]
            assert "no mission is under way" in told["error"]
        assert office.reloads == 0
        states["dan"] = State.IDLE
        _, told = post(site, "/api/settings/save", changes=FASTER, base=office.base, key=KEY)
        assert told["ok"], told
    assert office.reloads == 1


def test_the_form_is_told_over_the_page(site: Site) -> None:
    code, text, _ = site.get("/api/settings")
    assert code == 200
    assert "robots: cleo" in [section["name"] for section in json.loads(text)["sections"]]
