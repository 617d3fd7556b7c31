"""Places by name: saved in a file beside the journal, for everybody, by operators."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from navigation.config import Config
from navigation.dashboard.kept.places import (
    MOST_PLACES,
    SCHEMA,
    PlaceError,
    SavedPlace,
    SavedPlaces,
    places_file,
)
from navigation.mission.mission import State
from planner.scene import Bounds
from tests.navigation.dashboard.site import TOKEN, VIEWER, Page, Site
from tests.support.runs.shown import FakeDaemon, laboratory, shown_config

ARENA = Bounds(0.0, 0.0, 2.4, 1.8)
DOCK = {"x_m": 0.3, "y_m": 0.4, "heading_rad": 1.5}


def kept_config(folder: Path, **dashboard: object) -> Config:
    config = shown_config(**dashboard)
    recording = config.recording.model_copy(update={"journal": folder / "journal"})
    return config.model_copy(update={"recording": recording})


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Site]:
    with Site(FakeDaemon(kept_config(tmp_path), laboratory())) as site:
        yield site


def ask(page: Page, **message: object) -> dict[str, object]:
    page.send(type="place", id=1, **message)
    return page.hear("answer")


def test_places_are_saved_renamed_and_removed_for_everybody(site: Site, tmp_path: Path) -> None:
    with site.live() as page, site.live() as other:
        assert page.hear("places")["places"] == []
        page.join(name="Ann")
        other.hear("places")
        assert ask(page, do="save", name=" Dock ", station=DOCK)["ok"] is True
        there = other.hear("places")["places"]
        assert there == [{"name": "Dock", "x_m": 0.3, "y_m": 0.4, "heading_rad": 1.5}]
        assert ask(page, do="save", name="bench", station={"x_m": 1, "y_m": 1})["ok"] is True
        assert [place["name"] for place in other.hear("places")["places"]] == ["bench", "Dock"]
        assert ask(page, do="rename", name="dock", to="DOCK")["ok"] is True
        assert [place["name"] for place in other.hear("places")["places"]] == ["bench", "DOCK"]
        assert ask(page, do="remove", name="bench")["ok"] is True
        kept = json.loads((tmp_path / "journal.places.json").read_text())
        assert kept == {"schema": SCHEMA, "places": [{"name": "DOCK", **DOCK}]}
    again = SavedPlaces(tmp_path / "journal.places.json", ARENA)
    assert again.places == (SavedPlace("DOCK", 0.3, 0.4, 1.5),)
    assert site.dashboard.hub is not None
    lines = [line.text for line in site.dashboard.hub.chronicle.log.since(0, 99)[1]]
    assert "Ann saved the place 'Dock'" in lines
    assert "Ann removed the place 'bench'" in lines


@pytest.mark.parametrize(
    "message",
    [
        {"do": "save", "name": "", "station": DOCK},
        {"do": "save", "name": "   ", "station": DOCK},
        {"do": "save", "name": "x" * 41, "station": DOCK},
        {"do": "save", "name": "a\u202eb", "station": DOCK},
        {"do": "save", "name": 7, "station": DOCK},
        {"do": "save", "name": "kitchen", "station": DOCK},
        {"do": "save", "name": "far", "station": {"x_m": 9.0, "y_m": 0.1}},
        {"do": "save", "name": "odd", "station": {"x_m": float("nan"), "y_m": 0.1}},
        {"do": "save", "name": "odd"},
        {"do": "rename", "name": "nowhere", "to": "x"},
        {"do": "rename", "name": "Kitchen", "to": "hall"},
        {"do": "remove", "name": "nowhere"},
        {"do": "burn", "name": "Kitchen"},
    ],
)
def test_what_cannot_be_is_refused_and_changes_nothing(
    tmp_path: Path, message: dict[str, object]
) -> None:
    saved = SavedPlaces(tmp_path / "places.json", ARENA)
    saved.change({"do": "save", "name": "Kitchen", "station": DOCK})
    saved.change({"do": "save", "name": "Hall", "station": DOCK})
    before, text = saved.places, saved.path.read_text()
    with pytest.raises(PlaceError):
        saved.change(message)
    assert (saved.places, saved.path.read_text()) == (before, text)


def test_there_are_only_so_many(tmp_path: Path) -> None:
    saved = SavedPlaces(tmp_path / "places.json", ARENA)
    for number in range(MOST_PLACES):
        saved.change({"do": "save", "name": f"place {number}", "station": DOCK})
    with pytest.raises(PlaceError, match="remove one first"):
        saved.change({"do": "save", "name": "one more", "station": DOCK})


@pytest.mark.parametrize("text", ["", "{", "[]", '{"schema": "x"}', "\udcff", "[" * 99_999])
def test_a_file_that_cannot_be_read_is_left_as_it_is(tmp_path: Path, text: str) -> None:
    path = tmp_path / "places.json"
    data = text.encode(errors="surrogateescape")
    path.write_bytes(data)
    saved = SavedPlaces(path, ARENA)
    with pytest.raises(PlaceError, match="cannot be read"):
        saved.change({"do": "save", "name": "Dock", "station": DOCK})
    assert path.read_bytes() == data


def test_a_disk_that_takes_nothing_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    saved = SavedPlaces(tmp_path / "file" / "places.json", ARENA)
    with pytest.raises(PlaceError, match="file"):
        saved.change({"do": "save", "name": "Dock", "station": DOCK})
    assert saved.places == ()


def test_those_who_only_look_save_nothing(tmp_path: Path) -> None:
    config = kept_config(tmp_path, token=TOKEN, viewer_token=VIEWER)
    with Site(FakeDaemon(config)) as site, site.live(f"token.{VIEWER}") as page:
        page.join()
        answer = ask(page, do="save", name="Dock", station=DOCK)
        assert "no token" in str(answer["error"])
    assert not (tmp_path / "journal.places.json").exists()


def test_without_a_journal_they_are_among_the_runs() -> None:
    recording = shown_config().recording
    assert places_file(recording) == recording.runs_dir / "places.json"


def test_a_plan_stays_while_the_mission_is_paused(site: Site) -> None:
    path = laboratory().plan((0.2, 0.2), (2.2, 1.6))
    assert site.daemon.robot is not None
    mission = site.daemon.robot.mission
    driving = replace(mission, state=State.DRIVING)
    with site.live() as page:
        page.join()
        site.daemon.show(path=path, mission=driving)
        while not len(page.hear("plan")["arrays"]["points"]):
            pass
        paused = replace(mission, state=State.HOLDING, paused=True)
        site.daemon.show(path=None, mission=paused)
        hub = site.dashboard.hub
        assert hub is not None
        number = hub.plan_number
        assert page.hear("state")["type"] == "state"
        site.daemon.show(path=None, mission=paused)
        while page.hear("state")["paused"] is not True:
            pass
        assert hub.plan_number == number
        site.daemon.show(mission=mission)
        assert not len(page.hear("plan")["arrays"]["points"])
