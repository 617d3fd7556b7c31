"""Nothing is cut, covered or half empty, and STOP and the state keep their places, by geometry.

``layout.js`` says what counts: a card may be empty over 40 % of its height at most.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from navigation.loop.run_state import StageTimes
from tests.browser.acting import click_at, wait_for_picture
from tests.browser.pages import AWAY, HERE, Keep, OpenPage, drive
from tests.browser.programs.served import ShownProgram, until
from tests.browser.test_zones import ZONES, have_zones

PHONE: dict[str, Any] = {
    "viewport": {"width": 390, "height": 844},
    "has_touch": True,
    "is_mobile": True,
}
LAPTOP: dict[str, Any] = {"viewport": {"width": 1440, "height": 900}}
WIDE: dict[str, Any] = {"viewport": {"width": 1920, "height": 1080}}
SIZES = {"390": PHONE, "1440": LAPTOP, "1920": WIDE}
LAYOUT = (Path(__file__).parent / "layout.js").read_text()
TIMES = StageTimes(look_s=0.0247, roadmap_s=0.0195, plan_s=0.10742, wire_s=0.13716)
"""As of a slow computer: figures of a usual length."""
STOP_IS_REACHED = """() => {
  const stop = document.getElementById("stop");
  const box = stop.getBoundingClientRect();
  const parts = [0.05, 0.5, 0.95];
  return parts.every((x) => parts.every((y) =>
    stop.contains(document.elementFromPoint(box.left + x * box.width, box.top + y * box.height))));
}"""
REASON = "robot 12 is 0.31 m ahead, nearer than the distance that is kept"


def faults_of(page: Page) -> list[str]:
    found: list[str] = page.evaluate(LAYOUT)
    return found


def box_of(page: Page, selector: str) -> dict[str, int]:
    box = page.locator(selector).bounding_box()
    assert box is not None, selector
    return {side: round(value) for side, value in box.items()}


@pytest.mark.parametrize("size", list(SIZES))
def test_nothing_is_cut_covered_or_half_empty_and_stop_and_state_keep_their_places(
    size: str, open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    program.daemon.show(times=TIMES)
    page = open_page(**SIZES[size], allowed=AWAY)
    wait_for_picture(page)
    expect(page.locator("#health-wire .top")).to_have_text("137 ms")
    faults: list[str] = []
    places: dict[str, list[dict[str, int]]] = {"#stop": [], "#now": []}

    def look(state: str) -> None:
        page.evaluate("scrollTo(0, 0)")
        faults.extend(f"{state}: {fault}" for fault in faults_of(page))
        for selector, boxes in places.items():
            boxes.append(box_of(page, selector))
        keep(page, f"layout_{size}_{state}")

    look("idle")
    drive(program, page)
    expect(page.locator("#mission-state")).to_have_text("Driving")
    look("driving")
    click_at(page, *HERE)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    look("a_goal")
    page.locator("#pause").click()
    expect(page.locator("#mission-state")).to_have_text("Paused")
    look("paused")
    mission = replace(program.daemon.mission, paused=False, reason=REASON)
    program.daemon.become(mission)
    expect(page.locator("#sentence")).to_contain_text("nearer than")
    look("holding")
    page.keyboard.press("Space")
    until(program.is_stopped)
    expect(page.locator("#stopped-text")).to_contain_text("its wheels are off")
    look("stopped")
    program.take_away()
    expect(page.locator("#lost")).to_be_visible()
    look("lost")
    assert faults == [], faults
    for selector, boxes in places.items():
        assert boxes == boxes[:1] * len(boxes), f"{selector} has moved"


@pytest.mark.parametrize("size", ["1440", "1920"])
def test_all_about_a_drive_is_on_one_screen_with_the_log_beside_the_arena(
    size: str, open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page(**SIZES[size])
    wait_for_picture(page)
    high = SIZES[size]["viewport"]["height"]
    names = (".arena", ".goal", ".mission", ".health", ".log")
    cards = {name: box_of(page, name) for name in names}
    assert all(box["y"] + box["height"] <= high for box in cards.values()), cards
    arena, log = cards[".arena"], cards[".log"]
    assert log["x"] >= arena["x"] + arena["width"]
    assert log["y"] < arena["y"] + arena["height"]
    kept = ("#stop", "#now", ".log")
    before = [box_of(page, name) for name in kept]
    page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
    for name, box in zip(kept, before, strict=True):  # a page is scrolled to whole pixels
        assert box_of(page, name) == pytest.approx(box, abs=1), name


def test_on_a_phone_what_became_of_a_stop_is_read_whole_beside_a_refusal(
    open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    page = open_page(**PHONE)
    wait_for_picture(page)
    page.locator("#resume").click(force=True)  # is refused: nothing is paused
    expect(page.locator("#refusal")).to_be_visible()
    page.locator("#stop").tap()
    expect(page.locator("#stopped-text")).to_contain_text("its wheels are off")
    for where in ("0", "document.documentElement.scrollHeight"):
        page.evaluate(f"scrollTo(0, {where})")
        keep(page, "stopped_beside_a_refusal")
        covered = page.evaluate(
            """() => {
              const text = document.getElementById("stopped-text");
              const said = document.getElementById("said").getBoundingClientRect();
              return [...text.getClientRects()].filter((box) => {
                const ends = [[box.left + 1, box.top + 1], [box.right - 1, box.bottom - 1]];
                const hits = ends.map(([x, y]) => document.elementFromPoint(x, y));
                const isReached = hits.every((hit) => text.contains(hit));
                return !isReached || box.top < said.top - 1 || box.bottom > said.bottom + 1;
              }).length;
            }"""
        )
        assert covered == 0


@pytest.mark.parametrize("size", list(SIZES))
def test_zones_cut_and_cover_nothing_and_stop_and_state_keep_their_places(
    size: str, open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    have_zones(program)
    page = open_page(**SIZES[size])
    wait_for_picture(page)
    kept = ("#stop", "#now")
    before = [box_of(page, selector) for selector in kept]
    faults: list[str] = []

    def look(state: str) -> None:
        for where in ("document.documentElement.scrollHeight", "0"):
            page.evaluate(f"scrollTo(0, {where})")
            if not page.evaluate(STOP_IS_REACHED):
                faults.append(f"{state}, scrolled to {where}: STOP is covered")
            for selector, box in zip(kept[: 1 + (where == "0")], before, strict=False):
                assert box_of(page, selector) == box, f"{state}: {selector} has moved"
        faults.extend(f"{state}: {fault}" for fault in faults_of(page))
        keep(page, f"zones_{size}_{state}")

    page.locator("#zones-open").click()
    look("list")
    page.locator("#zones-new").click()
    look("new")
    page.locator("#zone-kind").select_option("lane")
    page.locator("#zone-save").dispatch_event("click")
    expect(page.locator("#zone-error")).not_to_be_empty()
    look("refused")
    page.locator("#zone-cancel").click()
    page.get_by_label("Edit door").click()
    look("edit")
    page.locator("#zones-close").click()
    page.locator("#zones-open").click()
    for name in [one["name"] for one in ZONES]:
        page.get_by_label(f"Delete {name}").click()
    expect(page.locator("#zones-none")).to_be_visible()
    look("none")
    assert faults == []
