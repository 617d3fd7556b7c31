"""Charts at full size, saved places, the layers made on demand, a name that is asked once."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from planner.roadmap.roadmap import Roadmap
from tests.browser.acting import click_at
from tests.browser.pages import Keep, OpenPage
from tests.browser.programs.served import ShownProgram
from tests.navigation.dashboard.kept.test_places_by_name import kept_config
from tests.support.runs.shown import FakeDaemon


@pytest.fixture
def program(roadmap: Roadmap, tmp_path: Path) -> Iterator[ShownProgram]:
    """It keeps places, and shows large pictures."""
    with ShownProgram(FakeDaemon(kept_config(tmp_path, picture_width_px=640), roadmap)) as program:
        yield program


def ready(page: Page) -> None:
    page.wait_for_function("() => globalThis.clearway?.connection.isUp")
    expect(page.locator("[data-layer=roadmap] path").first).to_be_attached()


def test_a_chart_is_read_at_full_size_with_the_keyboard(open_page: OpenPage, keep: Keep) -> None:
    page = open_page()
    ready(page)
    expect(page.locator("#health-clearance .top")).to_have_text("0.20 m")
    line = page.locator("#health-clearance path.line")
    expect(line).to_have_attribute("d", re.compile("L.*L"))  # three samples
    opener = page.locator("#health-clearance .chart-open")
    opener.press("Enter")
    expect(page.locator("#chart-title")).to_have_text("Clearance")
    expect(page.locator("#chart-area")).to_be_focused()
    expect(page.locator("#chart-value")).to_have_text("0.2 m, now")
    page.keyboard.press("ArrowLeft")
    expect(page.locator("#chart-value")).to_contain_text("0.2 m, ")
    expect(page.locator("#chart-value")).to_contain_text("s ago")
    keep(page, "chart")
    page.keyboard.press("Escape")
    expect(page.locator("#chart")).to_be_hidden()
    expect(opener).to_be_focused()


def test_places_are_saved_and_used(open_page: OpenPage, keep: Keep) -> None:
    page = open_page()
    ready(page)
    click_at(page, 0.3, 1.5)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    page.locator("#places-name").fill("<i>Dock</i>")
    page.locator("#places-name").press("Enter")
    use = page.get_by_role("button", name="Set <i>Dock</i> as the goal")
    expect(use).to_contain_text("0.30, 1.50 m")
    page.locator("#clear").click()
    use.click()
    expect(page.locator("#goal-stations li")).to_contain_text("0.30, 1.50 m")
    page.get_by_role("button", name="Rename <i>Dock</i>").click()
    page.locator("#places-name").fill("Bench")
    page.locator("#places-save").click()
    keep(page, "places")
    page.get_by_role("button", name="Remove Bench").click()
    expect(page.locator("#places-none")).to_be_visible()
    page.locator("#places-note button").click()
    expect(page.get_by_role("button", name="Set Bench as the goal")).to_be_visible()


def test_a_name_is_asked_once_and_shown_to_others(open_page: OpenPage) -> None:
    page, other = open_page(), open_page()
    ready(page)
    ready(other)
    expect(page.locator("#name-form")).to_be_hidden()
    page.keyboard.press("t")
    expect(other.locator("#seat-text")).to_have_text("somebody is in control")
    page.locator("#name-asked").fill("<b>Ann</b>")
    page.locator("#name-asked").press("Enter")
    expect(page.locator("#name-form")).to_be_hidden()
    expect(other.locator("#seat-text")).to_have_text("<b>Ann</b> is in control")
    page.reload()
    ready(page)
    expect(page.locator("#seat-text")).to_have_text("You are in control")
    expect(page.locator("#name-form")).to_be_hidden()


def test_layers_that_are_made_on_demand(open_page: OpenPage, keep: Keep) -> None:
    page = open_page()
    ready(page)
    page.keyboard.press("8")
    page.wait_for_function("() => heat.width > 50 && !heat.hidden")
    keep(page, "heat")
    page.keyboard.press("9")
    page.wait_for_function("() => Number(camera.dataset.number) > 2")
    keep(page, "camera")
    box = page.locator("#stage").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    expect(page.locator("#refusal-text")).to_contain_text("The camera's own picture is shown")
    expect(page.locator("#goal-stations")).to_be_hidden()
