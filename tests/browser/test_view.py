"""Zoom, keys, the stations of a draft, the log's filter."""

from collections.abc import Callable

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from tests.browser.acting import click_at, drag, on_screen, wait_for_picture

OpenPage = Callable[..., Page]
Keep = Callable[[Page, str], None]
HERE, THERE = (0.25, 0.75), (0.30, 1.50)


def zoom_of(page: Page) -> float:
    return float(page.locator("#stage").get_attribute("data-zoom") or 0)


def place_under(page: Page, x: float, y: float) -> list[float]:
    found: list[float] = page.evaluate(
        "([x, y]) => clearway.stage.place({clientX: x, clientY: y})", [x, y]
    )
    return found


def test_the_wheel_zooms_around_the_pointer_and_a_double_click_shows_all(
    open_page: OpenPage, keep: Keep
) -> None:
    page = open_page()
    wait_for_picture(page)
    x, y = on_screen(page, *THERE)
    page.mouse.move(x, y)
    before = place_under(page, x, y)
    page.mouse.wheel(0, -600)
    page.wait_for_function("() => Number(stage.dataset.zoom) > 2")
    assert place_under(page, x, y) == pytest.approx(before, abs=3e-3), "to a pixel"
    keep(page, "zoomed")
    expect(page.locator("#zoom-fit")).to_be_visible()
    page.locator("#stage").dblclick(position={"x": 100, "y": 100})
    page.wait_for_function("() => Number(stage.dataset.zoom) === 1")
    expect(page.locator("#zoom-fit")).to_be_hidden()


def test_a_goal_in_a_zoomed_arena_is_where_it_was_clicked(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    page.mouse.move(*on_screen(page, *THERE))
    page.mouse.wheel(0, -500)
    page.wait_for_function("() => Number(stage.dataset.zoom) > 1.5")
    click_at(page, *THERE)
    expect(page.locator("#goal-stations li")).to_contain_text("0.30, 1.50 m")


def test_the_middle_button_moves_what_is_shown(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    for _ in range(3):
        page.locator("#zoom-in").click()
    middle = page.locator("#stage").bounding_box()
    assert middle is not None
    x, y = middle["x"] + middle["width"] / 2, middle["y"] + middle["height"] / 2
    before = place_under(page, x, y)
    page.mouse.move(x, y)
    page.mouse.down(button="middle")
    page.mouse.move(x + 60, y + 30, steps=3)
    page.mouse.up(button="middle")
    assert place_under(page, x + 60, y + 30) == pytest.approx(before, abs=3e-3)
    expect(page.locator("#goal-stations li")).to_have_count(0)


def test_the_cursor_of_the_keys_stays_in_view(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    page.locator("#stage").focus()
    for key in ("+", "+", "+", "+"):
        page.keyboard.press(key)
    assert zoom_of(page) > 3
    for _ in range(12):
        page.keyboard.press("Shift+ArrowLeft")
    inside = page.evaluate(
        """() => {
          const cross = document.querySelector(".cross").getBoundingClientRect();
          const box = stage.getBoundingClientRect();
          return cross.left >= box.left && cross.right <= box.right;
        }"""
    )
    assert inside
    page.keyboard.press("0")
    assert zoom_of(page) == 1


def test_stations_are_dragged_removed_and_brought_back(open_page: OpenPage, keep: Keep) -> None:
    page = open_page()
    wait_for_picture(page)
    click_at(page, *HERE)
    click_at(page, *THERE, shift=True)
    stations = page.locator("#goal-stations li")
    expect(stations).to_have_count(2)
    drag(page, THERE, (0.30, 1.20))
    expect(stations.nth(1)).to_contain_text("0.30, 1.20 m")
    keep(page, "stations")
    page.get_by_label("Remove station 1").click()
    expect(stations).to_have_count(1)
    page.locator("#undo").click()
    expect(stations).to_have_count(2)
    page.locator("#undo").click()
    expect(stations.nth(1)).to_contain_text("0.30, 1.50 m")


def test_a_question_mark_opens_the_keys_and_stop_still_stops(
    open_page: OpenPage, keep: Keep
) -> None:
    page = open_page()
    wait_for_picture(page)
    page.keyboard.press("?")
    expect(page.locator("#keys")).to_be_visible()
    keep(page, "keys")
    page.locator("#stop").click()
    expect(page.locator("#mission-state")).to_have_text("Stopped")
    page.keyboard.press("Escape")
    expect(page.locator("#keys")).to_be_hidden()
    page.locator("#rearm").click()
    expect(page.locator("#mission-state")).not_to_have_text("Stopped")


def test_the_log_can_be_filtered(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    page.locator("#log-filter").select_option("trouble")
    levels = page.evaluate(
        """() => [...document.querySelectorAll("#log li")]
          .filter((item) => item.checkVisibility()).map((item) => item.dataset.level)"""
    )
    assert set(levels) <= {"warn", "stop"}


@pytest.mark.parametrize("width", [1360, 1920])
def test_the_arena_stays_in_view_and_a_wide_page_shows_the_log(
    open_page: OpenPage, keep: Keep, width: int
) -> None:
    page = open_page(viewport={"width": width, "height": 1000})
    wait_for_picture(page)
    if width == 1920:
        box = page.locator("#log").bounding_box()
        assert box is not None
        assert box["y"] + 100 < 1000, "the log is seen without scrolling"
    page.evaluate("scrollTo(0, document.body.scrollHeight)")
    top = page.evaluate("() => stage.getBoundingClientRect().top")
    assert top > 0
    keep(page, f"scrolled_{width}")
