"""What the planner could not keep, and what the link has met, is on the page in words."""

from collections.abc import Callable

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from tests.browser.acting import click_at, send_to, wait_for_picture
from tests.browser.live import Live
from tests.support.waiting import wait_until

pytestmark = pytest.mark.timed  # a robot drives in real time

OpenPage = Callable[..., Page]
WITHIN_THE_MARGIN = (0.097, 0.75)
"""Between the radius of 0.09 m and the margin of 0.015 m from the arena's edge."""
GIVEN_UP = "the margin of 0.015 m is given up"


def test_a_plan_that_gives_up_the_margin_says_so_before_and_while_it_is_driven(
    open_page: OpenPage, live: Live
) -> None:
    page = open_page()
    wait_for_picture(page)
    click_at(page, *WITHIN_THE_MARGIN)
    expect(page.locator("#goal-remarks")).to_contain_text(GIVEN_UP)
    send_to(page, *WITHIN_THE_MARGIN)
    expect(page.locator("#sentence")).to_contain_text(GIVEN_UP)
    expect(page.locator("#log")).to_contain_text(GIVEN_UP)
    assert wait_until(live.drives, 20.0)
    page.evaluate(  # a sentence that has no room for it
        """() => {
          const { connection } = clearway;
          const emit = connection.emit.bind(connection);
          connection.emit = (kind, message) => {
            if (kind === "state") message.mission.sentence = "driving slowly";
            emit(kind, message);
          };
        }"""
    )
    expect(page.locator("#sentence")).to_have_text("Driving slowly.")
    expect(page.locator("#reasons")).to_contain_text(GIVEN_UP)


def test_what_the_link_has_met_is_shown_from_the_first_time_on(
    open_page: OpenPage, live: Live
) -> None:
    page = open_page()
    wait_for_picture(page)
    page.evaluate(
        """() => {
          const { connection } = clearway;
          const emit = connection.emit.bind(connection);
          globalThis.met = { taken_back: 0, stray_hellos: 0, clock_jumps: 0, stale: 0 };
          connection.emit = (kind, message) => {
            if (kind === "state") Object.assign(message.link, met);
            emit(kind, message);
          };
        }"""
    )
    rows = page.locator("#health-link .odd li")
    expect(rows).to_have_count(0)
    page.evaluate("Object.assign(met, { taken_back: 2, stale: 5 })")
    expect(rows).to_have_text(
        ["2 taken back from another program", "5 permits and poses too old to be sent"]
    )
    assert "second program" in (rows.first.get_attribute("title") or "")
    page.evaluate("Object.assign(met, { stray_hellos: 1, clock_jumps: 3 })")
    expect(rows).to_have_count(4)
