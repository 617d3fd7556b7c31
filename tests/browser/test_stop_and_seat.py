"""Stop, a lost connection and who holds the arena, in a real browser."""

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from tests.browser.acting import click_at, wait_for_picture
from tests.browser.pages import AWAY, HERE, Keep, OpenPage, drive
from tests.browser.programs.served import ShownProgram, until
from tests.support.waiting import wait_until


@pytest.mark.parametrize("by", ["click", "key", "key on a focused button", "finger"])
def test_stop_is_given_by_any_press_and_is_latched(
    by: str, open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    page = open_page(has_touch=by == "finger")
    wait_for_picture(page)
    drive(program, page)
    press_stop(page, by)
    until(program.is_stopped)
    expect(page.locator("#stopped")).to_be_visible()
    expect(page.locator("#stopped-text")).to_contain_text("its wheels are off")
    expect(page.locator("#mission-state")).to_have_text("Stopped")
    keep(page, f"stopped_by_{by.replace(' ', '_')}")

    page.reload()
    wait_for_picture(page)
    expect(page.locator("#stopped")).to_be_visible()
    assert program.is_stopped(), "loading the page again does not leave the stop"


def press_stop(page: Page, by: str) -> None:
    if by == "click":
        page.locator("#stop").click()
    elif by == "finger":
        page.locator("#stop").tap()
    else:
        page.locator("#stage" if by == "key" else "#pause").focus()
        page.keyboard.press("Space")


@pytest.mark.timed  # says how long a stop takes
def test_stop_is_with_the_program_at_once(open_page: OpenPage, program: ShownProgram) -> None:
    page = open_page()
    wait_for_picture(page)
    drive(program, page)
    page.keyboard.press("Space")
    assert wait_until(program.is_stopped, 0.5)


def test_neither_loading_nor_coming_back_fires_the_stop(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page(allowed=AWAY)  # while the program is away
    wait_for_picture(page)
    drive(program, page)
    page.reload()
    wait_for_picture(page)
    program.take_away()
    expect(page.locator("#lost")).to_be_visible()
    program.bring_back()
    wait_for_picture(page)
    expect(page.locator("#lost")).to_be_hidden()
    assert program.drives()
    assert len(program.daemon.orders) == 1, "nothing but the drive was ordered"


def test_a_lost_connection_is_unmistakable_and_comes_back(
    open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    page = open_page(allowed=AWAY)
    wait_for_picture(page)
    program.take_away()
    expect(page.locator("#lost")).to_be_visible()
    expect(page.locator("#pill-text")).to_have_text("no connection")
    expect(page).to_have_title("No connection – Clearway")
    expect(page.locator("#send")).to_be_disabled()
    page.keyboard.press("Space")
    expect(page.locator("#refusal")).to_contain_text("STOP could not be delivered")
    keep(page, "lost")
    program.bring_back()
    expect(page.locator("#lost")).to_be_hidden()
    count = page.evaluate("clearway.picture.count")
    wait_for_picture(page, count + 2)
    assert program.daemon.orders == [], "the old STOP is not fired when the line is back"


def test_one_operator_holds_the_arena_and_everybody_may_stop(
    open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    first, second = open_page(), open_page()
    wait_for_picture(first)
    wait_for_picture(second)
    first.locator("#name").fill("<b>Ada</b>")
    first.locator("#name").press("Tab")
    first.locator("#seat").click()
    expect(first.locator("#seat-text")).to_have_text("You are in control")
    expect(second.locator("#seat-text")).to_have_text("<b>Ada</b> is in control")
    click_at(second, *HERE)
    expect(second.locator("#refusal")).to_contain_text("is in control")
    expect(second.locator("#goal-preview")).to_be_hidden()
    keep(second, "somebody_else_holds_the_arena")
    drive(program, first)
    second.keyboard.press("Space")
    until(program.is_stopped)
    expect(first.locator("#stopped")).to_be_visible()
    first.locator("#seat").click()
    expect(second.locator("#seat")).to_have_text("Take control")


def test_on_a_phone_nothing_covers_what_became_of_a_stop(
    open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    page = open_page(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    wait_for_picture(page)
    drive(program, page)
    page.evaluate("localStorage.removeItem('clearway.name')")
    expect(page.locator("#name-form")).to_be_visible()
    page.locator("#stop").tap()
    expect(page.locator("#stopped-text")).to_contain_text("its wheels are off")
    keep(page, "stopped_on_a_phone")
    expect(page.locator("#name-form")).to_be_hidden()
    text = page.locator("#stopped-text").bounding_box()
    card = page.locator("#said").bounding_box()
    assert text is not None
    assert card is not None
    assert card["y"] <= text["y"]
    assert text["y"] + text["height"] <= card["y"] + card["height"] + 1.0, "it is read whole"
