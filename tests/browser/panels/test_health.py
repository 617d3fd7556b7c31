"""The Health card: the cameras, each with its rate or why it is away, and what the link has met."""

from __future__ import annotations

from dataclasses import replace

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import expect

from firmware_protocol.host.counters import HostCounters
from tests.browser.acting import wait_for_picture
from tests.browser.pages import Keep, OpenPage
from tests.browser.programs.served import ShownProgram
from vision.camera.latest_frame import CameraStatus

AWAY = "the camera is not there: looked for again each 0.5 s"


@pytest.mark.parametrize("width", [1400, 390])
def test_each_camera_has_a_line_and_one_that_is_lost_says_why_without_moving_the_page(
    open_page: OpenPage, program: ShownProgram, keep: Keep, width: int
) -> None:
    page = open_page(viewport={"width": width, "height": 900})
    wait_for_picture(page)
    expect(page.locator("#health-camera h3")).to_have_text("Camera")
    whole = program.daemon.camera

    def have(right: CameraStatus) -> None:
        program.daemon.camera = replace(whole, each=(("left", whole), ("right", right)))

    have(whole)
    lines = page.locator("#health-camera .each li")
    expect(page.locator("#health-camera h3")).to_have_text("Cameras")
    expect(lines).to_have_count(2)
    expect(lines.nth(1)).to_contain_text("right: ")
    expect(lines.nth(1)).to_contain_text("pictures/s")
    before = page.locator("#health-wire").bounding_box()
    have(replace(whole, state="lost", reason=AWAY, rate_hz=0.0))
    expect(lines.nth(1)).to_have_text(f"right: {AWAY}")
    expect(lines.nth(1)).to_have_attribute("data-level", "bad")
    expect(page.locator("#health-camera .said .word")).to_have_text("1 of 2 away")
    assert page.locator("#health-wire").bounding_box() == before
    page.locator("#health-camera").scroll_into_view_if_needed()
    keep(page, f"cameras_{width}")


def test_what_the_link_has_met_is_shown_from_the_first_time_on(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    wait_for_picture(page)

    def meet(**counts: int) -> None:
        assert program.daemon.robot is not None
        program.daemon.show(link=replace(program.daemon.robot.link, sent=HostCounters(**counts)))

    rows = page.locator("#health-link .odd li")
    expect(rows).to_have_count(0)
    meet(taken_back=2, stale=5)
    expect(rows).to_have_text(
        ["2 taken back from another program", "5 permits and poses too old to be sent"]
    )
    assert "second program" in (rows.first.get_attribute("title") or "")
    meet(taken_back=2, stale=5, stray_hellos=1, clock_jumps=3)
    expect(rows).to_have_count(4)
