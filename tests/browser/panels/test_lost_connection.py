"""A connection that is lost for a moment costs a person nothing: neither work nor a held button."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import ElementHandle, Page, expect

from navigation.config.zones import ZoneSection
from planner.roadmap.roadmap import Roadmap
from tests.browser.acting import (
    click_at,
    lose_connection,
    on_screen,
    regain_connection,
    wait_for_picture,
)
from tests.browser.pages import AWAY, HERE, THERE, OpenPage
from tests.browser.programs.served import ShownProgram, until
from tests.navigation.dashboard.kept.test_places_by_name import kept_config
from tests.support.runs.shown import FakeDaemon

DESK = [[1.05, 0.15], [1.6, 0.15], [1.6, 0.5], [1.05, 0.5]]


@pytest.fixture
def program(roadmap: Roadmap, tmp_path: Path) -> Iterator[ShownProgram]:
    """It keeps places."""
    with ShownProgram(FakeDaemon(kept_config(tmp_path), roadmap)) as program:
        yield program


def hold(page: Page, selector: str) -> ElementHandle:
    """Give an element the focus, and keep hold of it."""
    page.locator(selector).focus()
    return page.locator(selector).element_handle()


def lose_and_regain(page: Page) -> None:
    lose_connection(page)
    regain_connection(page)


def has_focus(held: ElementHandle) -> bool:
    return bool(held.evaluate("(element) => element === document.activeElement"))


def test_a_button_that_removes_a_station_stays_in_a_hand(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    click_at(page, *HERE)
    click_at(page, *THERE, shift=True)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    held = hold(page, "#remove-2")
    lose_and_regain(page)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    assert has_focus(held)
    page.keyboard.press("Enter")
    expect(page.locator("#goal-stations li")).to_have_count(1)


def test_a_saved_place_stays_in_a_hand(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    page.locator("#places-name").fill("Dock")
    page.locator("#places-name").press("Enter")
    held = hold(page, "#places-list .use")
    lose_and_regain(page)
    assert has_focus(held)


def test_a_zone_of_the_list_and_one_that_is_half_drawn_stay(
    open_page: OpenPage, program: ShownProgram
) -> None:
    desk = {"name": "desk", "kind": "keep_out", "polygon": DESK}
    program.daemon.zones.put(ZoneSection.model_validate(desk))
    page = open_page()
    wait_for_picture(page)
    page.locator("#zones-open").click()
    held = hold(page, "#zones-list [title='Edit desk']")
    lose_and_regain(page)
    assert has_focus(held)
    page.locator("#zones-new").click()
    click_at(page, 0.3, 0.6)
    click_at(page, 0.6, 0.6)
    page.locator("#zone-name").fill("half")
    lose_and_regain(page)
    expect(page.locator("#zone-name")).to_be_focused()
    click_at(page, 0.6, 0.9)
    page.locator("#zone-save").click()
    until(lambda: [one.name for one in program.daemon.zones.sections] == ["desk", "half"])


def test_the_log_stays_where_it_is_read(open_page: OpenPage, program: ShownProgram) -> None:
    for number in range(100):
        program.hub.note("info", f"line {number}")
    page = open_page()
    wait_for_picture(page)
    log = page.locator("#log")
    expect(log).to_contain_text("line 99")
    log.evaluate("(list) => { list.scrollTop = 300; }")
    lose_and_regain(page)
    expect(log).to_contain_text("line 99")
    assert log.evaluate("(list) => list.scrollTop") == pytest.approx(300.0, abs=1.0)


def test_a_name_that_is_being_typed_stays_and_so_does_the_button_of_the_seat(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    wait_for_picture(page)
    held = hold(page, "#seat")
    page.keyboard.press("Enter")
    expect(page.locator("#seat")).to_have_text("Release")
    lose_and_regain(page)
    assert has_focus(held)
    page.locator("#name-asked").press_sequentially("An")
    lose_and_regain(page)
    page.keyboard.type("na")
    page.keyboard.press("Enter")
    expect(page.locator("#name")).to_have_value("Anna")


def test_a_draft_keeps_its_stations_when_one_more_is_refused(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page(allowed=AWAY)
    wait_for_picture(page)
    click_at(page, *HERE)
    click_at(page, *THERE, shift=True)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    program.bring_back()  # restarted: no viewer is in control
    program.hub.seat.take("somebody-elses-key", "Ada", program.hub.clock())
    expect(page.locator("#seat-text")).to_have_text("Ada is in control")
    click_at(page, 0.60, 1.55, shift=True)
    expect(page.locator("#refusal-text")).to_contain_text("Ada is in control")
    expect(page.locator("#goal-stations li")).to_have_count(2)


def test_a_draft_is_planned_again_once_a_program_that_has_begun_again_is_taken(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page(allowed=AWAY)
    wait_for_picture(page)
    click_at(page, *THERE)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    program.bring_back()
    expect(page.locator("#goal-preview")).to_contain_text("take control first")
    page.locator("#seat").click()
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")


def test_a_press_in_the_arena_meanwhile_is_not_lost_in_silence(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    lose_connection(page)
    click_at(page, *HERE)
    expect(page.locator("#refusal-text")).to_have_text("There is no connection to the program.")
    regain_connection(page)
    click_at(page, *HERE)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    lose_connection(page)
    click_at(page, *THERE, shift=True)
    expect(page.locator("#goal-preview")).to_contain_text("there is no connection")
    regain_connection(page)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    expect(page.locator("#goal-stations li")).to_have_count(2)


def test_a_view_stays(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    page.mouse.move(*on_screen(page, *HERE))
    page.mouse.wheel(0.0, -400.0)
    page.wait_for_function("Number(stage.dataset.zoom) > 1.5")
    before = page.locator("#overlay").get_attribute("viewBox")
    lose_and_regain(page)
    assert page.locator("#overlay").get_attribute("viewBox") == before


def test_a_page_that_could_not_listen_does_not_take_the_program_for_silent(
    open_page: OpenPage,
) -> None:
    page = open_page()
    wait_for_picture(page)
    page.evaluate("clearway.connection.on('down', () => { globalThis.wasDown = true; })")
    for _ in range(3):
        page.evaluate(
            """() => new Promise((resolve) => {
              const end = performance.now() + 1700;
              while (performance.now() < end);
              clearway.connection.on("state", resolve);
            })"""
        )
    assert page.evaluate("globalThis.wasDown") is None
