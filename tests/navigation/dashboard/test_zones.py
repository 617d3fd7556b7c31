"""Zones on the line to a page: sent when they change, changed by operators, read by everybody."""

import threading
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from navigation.config.dashboard import DashboardSection
from navigation.config.zones import ZoneSection
from navigation.dashboard.messages.zones import zones_message
from navigation.dashboard.replay.player import Player
from navigation.dashboard.replay.replayed_run import ReplayedRun
from navigation.recording.events import ZonesChanged
from navigation.recording.tape import read_tape
from planner.scene import FloatArray
from tests.navigation.dashboard.site import KEY, TOKEN, VIEWER, Page, Site
from tests.support.runs.packed import unpack
from tests.support.runs.recordings import EVERY, RecordedBench, make_recording
from tests.support.waiting import wait_until

DESK: dict[str, Any] = {
    "name": "desk",
    "kind": "keep_out",
    "polygon": [[1.0, 0.5], [1.4, 0.5], [1.4, 0.8]],
}
SLOW: dict[str, Any] = {
    "name": "door",
    "kind": "slow",
    "circle": [0.5, 0.5, 0.25],
    "speed_m_s": 0.1,
}
SQUARE = [[1.0, 0.7], [1.4, 0.7], [1.4, 1.1], [1.0, 1.1]]
LANE: dict[str, Any] = {
    "name": "aisle",
    "kind": "lane",
    "line": [[0.2, 0.2], [2.0, 0.2]],
    "width_m": 0.3,
    "cost": 0.25,
}


@pytest.mark.parametrize("zone", [DESK, SLOW, LANE], ids=["polygon", "circle", "line"])
def test_a_zone_is_told_as_a_configuration_has_it_and_as_sentences_name_it(
    zone: dict[str, Any],
) -> None:
    section = ZoneSection.model_validate(zone)
    head, _ = unpack(zones_message((section.zone(),), 7, 3))
    assert (head["type"], head["revision"], head["number"]) == ("zones", 7, 3)
    (told,) = head["zones"]
    assert told.pop("title") == str(section.zone())
    assert told == zone
    assert ZoneSection.model_validate(told) == section


def test_a_mask_is_told_as_outlines_without_the_folder_of_its_file(tmp_path: Path) -> None:
    grid = np.full((20, 30), 255, dtype=np.uint8)
    grid[5:10, 10:20] = 0
    cv2.imwrite(str(tmp_path / "mask.pgm"), grid)
    file = tmp_path / "mask.yaml"
    file.write_text(
        "image: mask.pgm\nresolution: 0.1\norigin: [1.0, 2.0, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: scale\n"
    )
    zone = ZoneSection.model_validate({"name": "floor", "kind": "keep_out", "mask": str(file)})
    (told,) = unpack(zones_message((zone.zone(),), 0, 1))[0]["zones"]
    assert told["mask"] == "mask.yaml"
    (outline,) = told["outlines"]
    corners = {tuple(place) for place in outline}
    assert corners == {(2.0, 3.0), (3.0, 3.0), (3.0, 3.5), (2.0, 3.5)}


def hear_of(page: Page, *names: str) -> dict[str, Any]:
    """The next message that has these zones, in this order."""
    while True:
        told = page.hear("zones")
        if [zone["name"] for zone in told["zones"]] == list(names):
            return told


def test_a_page_hears_the_zones_when_it_comes_and_when_they_change(site: Site) -> None:
    site.daemon.zones.put(ZoneSection.model_validate(DESK))
    with site.live() as page, site.live() as other:
        hear_of(page, "desk")
        hear_of(other, "desk")
        page.join()
        page.send(type="take", id=1)
        page.hear("answer")
        assert page.order("zone_put", zone=SLOW) == {"type": "answer", "id": 1, "ok": True}
        assert hear_of(page, "desk", "door")["revision"] == 2
        assert hear_of(other, "desk", "door")["revision"] == 2
        assert page.order("zone_remove", name="desk")["ok"]
        hear_of(page, "door")
        assert page.order("zone_undo")["ok"]
        hear_of(page, "desk", "door")
        hear_of(other, "desk", "door")
    hub = site.dashboard.hub
    assert hub is not None
    texts = [line.text for line in hub.chronicle.log.since(0, 99)[1]]
    assert [text for text in texts if "ZONE" in text] == [
        "somebody: ZONE PUT 'door'",
        "somebody: ZONE REMOVE 'desk'",
        "somebody: ZONE UNDO",
    ]


def test_stop_is_taken_while_a_zone_waits_for_the_disk(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    hangs, well = threading.Event(), threading.Event()

    def put(_zone: ZoneSection) -> None:
        hangs.set()
        assert well.wait(60.0)

    monkeypatch.setattr(site.daemon.zones, "put", put)
    with site.live() as page:
        page.join()
        page.send(type="take", id=1)
        page.hear("answer")
        page.send(type="order", id=2, order="zone_put", zone=SLOW)
        assert hangs.wait(60.0)
        page.send(type="order", id=3, order="stop")
        assert page.hear("answer")["id"] == 3
        well.set()
        assert page.hear("answer") == {"type": "answer", "id": 2, "ok": True}


def test_a_change_that_waited_for_the_disk_is_refused_to_a_page_that_lost_control(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It took effect while another operator had the arena."""
    hangs, well = threading.Event(), threading.Event()
    put = site.daemon.zones.put

    def slow(zone: ZoneSection) -> None:
        hangs.set()
        assert well.wait(60.0)
        put(zone)

    monkeypatch.setattr(site.daemon.zones, "put", slow)
    with site.live() as page, site.live() as other:
        page.join()
        page.send(type="take", id=1)
        page.hear("answer")
        page.send(type="order", id=2, order="zone_put", zone=DESK)
        assert hangs.wait(60.0)
        page.send(type="order", id=3, order="zone_put", zone=SLOW)
        page.send(type="release")
        other.join(key=KEY[::-1])
        assert wait_until(other.take)
        well.set()
        answers = {(told := page.hear("answer"))["id"]: told for _ in range(2)}
        assert answers[2]["ok"]
        assert answers[3] == {"type": "answer", "id": 3, "ok": False, "error": "take control first"}
    assert [zone.name for zone in site.daemon.zones.sections] == ["desk"]


def test_an_undo_takes_back_no_change_that_its_page_has_not_seen(site: Site) -> None:
    """A keep-out zone that somebody had just drawn at the command line was gone."""
    zones = site.daemon.zones
    with site.live() as page:
        page.join()
        page.send(type="take", id=1)
        page.hear("answer")
        page.order("zone_put", zone=SLOW)
        seen = hear_of(page, "door")["revision"]
        zones.put(ZoneSection.model_validate(DESK))
        answer = page.order("zone_undo", revision=seen)
        assert answer["error"] == "zones were changed by someone else since: look at them first"
        assert [zone.name for zone in zones.sections] == ["door", "desk"]
        for revision in ("1", True, 1.5):
            error = page.order("zone_undo", revision=revision)["error"]
            assert error.startswith("revision: must be a whole number, not ")
        assert page.order("zone_undo", revision=seen + 1)["ok"]
        assert [zone.name for zone in zones.sections] == ["door"]


def test_a_page_hears_the_roadmap_again_when_a_keep_out_zone_is_put_and_removed(site: Site) -> None:
    def roads(told: dict[str, Any]) -> FloatArray:
        """Points of the roadmap within the corners of the zone."""
        arrays = told["arrays"]
        usable = np.repeat(arrays["chain_usable"], np.diff(arrays["chain_first"])).astype(bool)
        x, y = arrays["chain"].reshape(-1, 2)[usable].T
        return np.flatnonzero((np.abs(x - 1.2) < 0.2) & (np.abs(y - 0.9) < 0.2))

    shut = {"name": "shut", "kind": "keep_out", "polygon": SQUARE}
    with site.live() as page:
        assert len(roads(page.hear("world")))
        for change, is_open in ((shut, False), ({**shut, "kind": "wait"}, True)):
            site.daemon.zones.put(ZoneSection.model_validate(change))
            site.daemon.cycle()
            told = page.hear("world")
            assert (len(roads(told)) > 0) is is_open
            assert told["objects"] == 7


def test_a_zone_that_cannot_be_is_refused_in_a_sentence_and_nothing_is_changed(site: Site) -> None:
    with site.live() as page:
        page.join()
        page.send(type="take", id=1)
        page.hear("answer")
        crossed = {**DESK, "polygon": [[0, 0], [1, 1], [1, 0], [0, 1]]}
        for zone in (crossed, {**SLOW, "speed_m_s": -1.0}, {**DESK, "robots": ["ada"]}, "desk"):
            answer = page.order("zone_put", zone=zone)
            assert not answer["ok"]
            assert "\n" not in answer["error"]
        assert "there are no zones" in page.order("zone_remove", name="desk")["error"]
        assert page.order("zone_undo")["error"] == "no change of zones to take back"
    assert site.daemon.zones.revision == 0


def test_a_page_may_name_no_file_of_this_computer(site: Site) -> None:
    with site.live() as page:
        page.join()
        page.send(type="take", id=1)
        page.hear("answer")
        answer = page.order(
            "zone_put", zone={"name": "a", "kind": "keep_out", "mask": "/etc/hosts"}
        )
        assert "not on the page" in answer["error"]
    assert site.daemon.zones.revision == 0


def test_zones_are_read_by_viewers_and_changed_by_the_operator_in_control(guarded: Site) -> None:
    guarded.daemon.zones.put(ZoneSection.model_validate(DESK))
    with guarded.live(f"token.{VIEWER}") as viewer:
        viewer.join()
        hear_of(viewer, "desk")
        for order in ("zone_put", "zone_remove", "zone_undo"):
            answer = viewer.order(order, zone=SLOW, name="desk")
            assert answer["error"] == "this token is for looking and stopping only"
    with guarded.live(f"token.{TOKEN}") as page:
        page.join()
        assert page.order("zone_put", zone=SLOW)["error"] == "take control first"
    assert guarded.daemon.zones.revision == 1


def test_a_recording_shows_the_zones_of_its_moment(tmp_path: Path) -> None:
    zones = tuple(ZoneSection.model_validate(one).zone() for one in (DESK, SLOW))

    def each(bench: RecordedBench) -> None:
        bench.recorder.put(ZonesChanged(bench.now_s, 0, zones[:1]))
        bench.frames(3)
        bench.recorder.put(ZonesChanged(bench.now_s, 0, zones))
        bench.frames(3)

    (file,) = make_recording(tmp_path, each, **EVERY)
    tape = read_tape(file)
    player = Player(tape.end_s - tape.begin_s, playing=False)
    run = ReplayedRun(tape, player, DashboardSection(port=0), lambda: 0.0)
    try:
        assert (run.zones.zones(), run.zones.revision) == (zones[:1], 1)
        player.seek(0.0, player.duration_s)
        assert (run.zones.zones(), run.zones.revision) == (zones, 2)
    finally:
        run.close()
