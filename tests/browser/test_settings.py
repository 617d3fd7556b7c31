"""The settings' form in a real browser, against a desk over a copy of the shipped simulation."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from navigation.cli.setup.check import file_problems
from navigation.config.load import load_config
from navigation.dashboard.settings.desk import Around, Desk
from tests.browser.acting import lose_connection, regain_connection, wait_for_picture
from tests.browser.axe import serious_findings
from tests.browser.pages import drive
from tests.browser.programs.served import ShownProgram, until
from tests.support.runs.shown import ROOT

OpenPage = Callable[..., Page]
Keep = Callable[[Page, str], None]


@pytest.fixture
def file(program: ShownProgram, tmp_path: Path) -> Path:
    """The configuration that the page may change."""
    shutil.copytree(ROOT / "configs", tmp_path / "etc")
    file, state = tmp_path / "etc" / "simulation.yaml", tmp_path / "state"
    desk = Desk(Around(file, state, {}, file_problems, lambda: ([], []), reload=lambda: None))
    program.bring_back(desk=desk)
    return file


def test_a_value_is_checked_while_it_is_typed_saved_and_taken_back(
    open_page: OpenPage, file: Path, keep: Keep
) -> None:
    page = open_page()
    wait_for_picture(page)
    page.locator("#settings-open").click()
    rate = page.get_by_label("rate_hz", exact=True).first
    expect(rate).to_have_value("30")
    rate.fill("-3")
    expect(rate).to_have_attribute("aria-invalid", "true")
    expect(page.locator("[data-key='camera.rate_hz'] .problem")).to_contain_text("must be > 0")
    page.locator("#settings-save").click(force=True)  # it says why it does nothing
    expect(page.locator("#settings-said")).to_contain_text("Something is wrong")
    keep(page, "settings_wrong")
    assert serious_findings(page) == []
    rate.fill("25")
    expect(rate).to_have_attribute("aria-invalid", "false")
    expect(page.locator("#settings-save")).to_have_attribute("aria-disabled", "false")
    page.locator("#settings-save").click()
    expect(page.locator("#settings-said")).to_contain_text("Saved camera.rate_hz")
    assert load_config(file, {}).camera.rate_hz == 25.0
    page.locator("#settings-undo").click()
    expect(page.locator("#settings-said")).to_contain_text("is undone")
    assert load_config(file, {}).camera.rate_hz == 30.0


@pytest.mark.parametrize("size", [(1400, 900), (390, 844), (700, 450)])
def test_stop_is_never_covered_by_the_settings(
    open_page: OpenPage, program: ShownProgram, file: Path, size: tuple[int, int]
) -> None:
    page = open_page(viewport={"width": size[0], "height": size[1]})
    wait_for_picture(page)
    page.locator("#settings-open").click()
    expect(page.locator("#settings")).to_be_visible()
    page.locator("#stop").click()
    until(program.is_stopped)


def test_keys_are_found_by_their_meaning_and_the_form_by_keyboard(
    open_page: OpenPage, file: Path
) -> None:
    page = open_page()
    wait_for_picture(page)
    page.locator("#settings-open").focus()
    page.keyboard.press("Enter")
    expect(page.locator("#settings-close")).to_be_focused()
    page.locator("#settings-find").fill("mains")
    expect(page.get_by_label("mains_hz", exact=True)).to_be_visible()
    expect(page.get_by_label("radius_m", exact=True).first).to_be_hidden()
    page.locator("#settings-close").focus()
    page.keyboard.press("Escape")
    expect(page.locator("#settings")).to_be_hidden()
    expect(page.locator("#settings-open")).to_be_focused()


def test_a_form_that_is_read_stays_as_it_is_when_the_connection_comes_back(
    open_page: OpenPage, file: Path
) -> None:
    page = open_page()
    wait_for_picture(page)
    page.locator("#settings-open").click()
    page.locator("#settings-find").fill("mains")
    field = page.get_by_label("mains_hz", exact=True)
    field.focus()
    held = field.element_handle()
    lose_connection(page)
    with page.expect_response("**/api/settings"):
        regain_connection(page)
    page.evaluate("fetch('/api/settings').then((answer) => answer.text())")  # it has the first one
    assert held.evaluate("(field) => field === document.activeElement")


def test_a_space_is_typed_while_nothing_moves_and_stops_while_something_does(
    open_page: OpenPage, program: ShownProgram, file: Path
) -> None:
    page = open_page()
    wait_for_picture(page)
    page.locator("#settings-open").click()
    bounds = page.get_by_label("bounds_m", exact=True)
    bounds.fill("")
    bounds.press_sequentially("0, 0, 2.4, 1.7")
    expect(bounds).to_have_value("0, 0, 2.4, 1.7")
    assert program.daemon.orders == []
    page.locator("#settings-close").click()
    drive(program, page)
    page.locator("#settings-open").click()
    page.locator("#settings-find").focus()
    page.keyboard.press("Space")
    until(program.is_stopped)
    expect(page.locator("#settings-find")).to_have_value("")
