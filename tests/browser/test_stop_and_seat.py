"""Stop, a lost connection and who holds the arena, in a real browser."""

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import expect

from navigation.mission.mission import State
from tests.browser.acting import click_at, wait_for_picture
from tests.browser.live import Live
from tests.browser.pages import HERE, Keep, OpenPage, drive
from tests.support.waiting import wait_until

pytestmark = pytest.mark.timed  # a robot drives in real time


@pytest.mark.parametrize("by", ["click", "key", "key on a focused button", "finger"])
def test_stop_stops_the_wheels_at_once_and_is_latched(
    by: str, open_page: OpenPage, live: Live, keep: Keep
) -> None:
    page = open_page(has_touch=by == "finger")
    wait_for_picture(page)
    drive(live, page)
    if by == "click":
        page.locator("#stop").click()
    elif by == "finger":
        page.locator("#stop").tap()
    else:
        page.locator("#stage" if by == "key" else "#pause").focus()
        page.keyboard.press("Space")
    assert wait_until(lambda: live.state is State.STOPPED, 1.0)
    assert live.stands_within(1.5), "0.3 m/s and 0.5 m/s2 are 0.6 s of braking at most"
    expect(page.locator("#stopped")).to_be_visible()
    expect(page.locator("#stopped-text")).to_contain_text("its wheels are off")
    expect(page.locator("#mission-state")).to_have_text("Stopped")
    keep(page, f"stopped_by_{by.replace(' ', '_')}")

    page.reload()
    wait_for_picture(page)
    expect(page.locator("#stopped")).to_be_visible()
    assert live.state is State.STOPPED, "loading the page again does not leave the stop"
    assert not live.is_moving()

    expect(page.locator("#rearm")).to_be_enabled()
    page.locator("#rearm").click()
    expect(page.locator("#stopped")).to_be_hidden()
    assert wait_until(lambda: not live.daemon.link.snapshot().estopped)
    assert not live.is_moving(), "re-arming moves nothing"


def test_neither_loading_nor_coming_back_fires_the_stop(open_page: OpenPage, live: Live) -> None:
    page = open_page(allowed="ERR_CONNECTION_REFUSED")  # while the program is away
    wait_for_picture(page)
    drive(live, page)
    page.reload()
    wait_for_picture(page)
    assert live.state is not State.STOPPED
    live.take_away()
    expect(page.locator("#lost")).to_be_visible()
    live.bring_back()
    wait_for_picture(page)
    expect(page.locator("#lost")).to_be_hidden()
    assert live.state is not State.STOPPED


def test_a_lost_connection_is_unmistakable_and_comes_back(
    open_page: OpenPage, live: Live, keep: Keep
) -> None:
    page = open_page(allowed="ERR_CONNECTION_REFUSED")
    wait_for_picture(page)
    live.take_away()
    expect(page.locator("#lost")).to_be_visible(timeout=3000)
    expect(page.locator("#pill-text")).to_have_text("no connection")
    expect(page).to_have_title("No connection – Clearway")
    expect(page.locator("#send")).to_be_disabled()
    page.keyboard.press("Space")
    expect(page.locator("#refusal")).to_contain_text("STOP could not be delivered")
    keep(page, "lost")
    live.bring_back()
    expect(page.locator("#lost")).to_be_hidden()
    count = page.evaluate("clearway.picture.count")
    wait_for_picture(page, count + 2)
    assert live.state is not State.STOPPED, "the old STOP is not fired when the line is back"


def test_one_operator_holds_the_arena_and_everybody_may_stop(
    open_page: OpenPage, live: Live, keep: Keep
) -> None:
    first, second = open_page(), open_page()
    wait_for_picture(first)
    wait_for_picture(second)
    first.locator("#name").fill("<b>Ada</b>")
    first.locator("#name").press("Tab")
    first.locator("#seat").click()
    expect(first.locator("#seat-text")).to_have_text("You hold the arena")
    expect(second.locator("#seat-text")).to_have_text("<b>Ada</b> holds the arena")
    click_at(second, *HERE)
    expect(second.locator("#refusal")).to_contain_text("holds the arena")
    expect(second.locator("#goal-preview")).to_be_hidden()
    keep(second, "somebody_else_holds_the_arena")
    drive(live, first)
    second.keyboard.press("Space")
    assert live.stands_within(2.0)
    expect(first.locator("#stopped")).to_be_visible()
    first.locator("#seat").click()
    expect(second.locator("#seat")).to_have_text("Take arena")


def test_pause_holds_and_resume_resumes(open_page: OpenPage, live: Live) -> None:
    page = open_page()
    wait_for_picture(page)
    drive(live, page)
    page.locator("#pause").click()
    expect(page.locator("#mission-state")).to_have_text("Paused")
    assert live.stands_within(3.0)
    page.locator("#resume").click()
    expect(page.locator("#mission-state")).to_have_text("Driving", timeout=20_000)
    assert wait_until(live.is_moving, 20.0)
