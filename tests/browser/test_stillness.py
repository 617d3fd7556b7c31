"""Nothing that appears on the page moves or covers what can be clicked, whatever happens."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page

from tests.browser.acting import wait_for_picture

OpenPage = Callable[..., Page]
Keep = Callable[[Page, str], None]
Places = dict[str, dict[str, Any]]
DESKTOP: dict[str, Any] = {"viewport": {"width": 1280, "height": 800}}
PHONE: dict[str, Any] = {
    "viewport": {"width": 390, "height": 844},
    "has_touch": True,
    "is_mobile": True,
    "device_scale_factor": 2,
}
TABLET: dict[str, Any] = {"viewport": {"width": 800, "height": 1100}, "has_touch": True}
LAPTOP: dict[str, Any] = {"viewport": {"width": 1440, "height": 900}}
DEVICES = {"desktop": DESKTOP, "laptop": LAPTOP, "phone": PHONE, "tablet": TABLET}
SHOWN = {"driving", "holding", "stopped", "refused and stopped", "refused and lost", "camera lost"}
SHOWN |= {"a token is wanted", "a goal with remarks", "a goal without a plan", "twenty stations"}
SHOWN |= {"link's counters", "failed"}


@pytest.mark.parametrize("scrolled", ["top", "bottom"])
@pytest.mark.parametrize("device", list(DEVICES))
def test_nothing_that_appears_moves_or_covers_what_can_be_clicked(
    device: str, scrolled: str, open_page: OpenPage, keep: Keep
) -> None:
    page = open_page(**DEVICES[device])
    wait_for_picture(page)
    leave_the_program(page)
    if scrolled == "bottom":
        page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
    page.evaluate("stillness.calm()")
    calm: Places = page.evaluate("stillness.measure()")
    assert {"stop", "stage", "send", "pause", "adding", "name", "layers-open"} <= set(calm)
    moved = []
    seen = dict(calm)
    for name in page.evaluate("stillness.names"):
        now: Places = page.evaluate("name => stillness.enter(name)", name)
        for what, is_now in now.items():
            was = seen.setdefault(what, is_now)  # what appears later has one place too
            if is_now["place"] != was["place"]:
                moved.append(f"{name}: {what} moved from {was['place']} to {is_now['place']}")
            if what in calm and calm[what]["reached"] and not is_now["reached"]:
                moved.append(f"{name}: {what} is covered")
        if scrolled == "top" and name in SHOWN:
            keep(page, f"still_{device}_{name.replace(' ', '_').replace(',', '')}")
    assert moved == []


def leave_the_program(page: Page) -> None:
    """Keep the newest state and greeting, and let the page hear nothing more from the program."""
    page.evaluate(
        """() => new Promise((resolve) => {
          const { connection } = clearway;
          connection.on("hello", (hello) => { globalThis.lastHello = hello; });
          connection.on("state", (state) => {
            globalThis.lastState = state;
            if (globalThis.lastHello) resolve();
          });
          connection.useToken(connection.token ?? "");  // greets again
        })"""
    )
    page.evaluate((Path(__file__).parent / "stillness.js").read_text())
