"""The Health card of a run with several cameras: a line each, with its rate or why it is away."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from tests.browser.acting import wait_for_picture
from tests.browser.live import Live
from vision.camera.latest_frame import CameraStatus

pytestmark = pytest.mark.timed  # the simulation behind the page runs in real time

OpenPage = Callable[..., Page]
Keep = Callable[[Page, str], Path]
AWAY = "the camera is not there: looked for again each 0.5 s"


@pytest.mark.parametrize("width", [1400, 390])
def test_each_camera_has_a_line_and_one_that_is_lost_says_why_without_moving_the_page(
    open_page: OpenPage, live: Live, monkeypatch: pytest.MonkeyPatch, keep: Keep, width: int
) -> None:
    page = open_page(viewport={"width": width, "height": 900})
    wait_for_picture(page)
    expect(page.locator("#health-camera h3")).to_have_text("Camera")
    whole = live.daemon.camera.status
    lost: list[str] = []

    def status() -> CameraStatus:
        one = whole()
        away = replace(one, state="lost", reason=AWAY, rate_hz=0.0)
        return replace(one, each=(("left", one), ("right", away if lost else one)))

    monkeypatch.setattr(live.daemon.camera, "status", status)
    lines = page.locator("#health-camera .each li")
    expect(page.locator("#health-camera h3")).to_have_text("Cameras")
    expect(lines).to_have_count(2)
    expect(lines.nth(1)).to_contain_text("right: ")
    expect(lines.nth(1)).to_contain_text("pictures/s")
    before = page.locator("#health-wire").bounding_box()
    lost.append("right")
    expect(lines.nth(1)).to_have_text(f"right: {AWAY}")
    expect(lines.nth(1)).to_have_attribute("data-level", "bad")
    expect(page.locator("#health-camera .said .word")).to_have_text("1 of 2 away")
    assert page.locator("#health-wire").bounding_box() == before
    page.locator("#health-camera").scroll_into_view_if_needed()
    keep(page, f"cameras_{width}")
