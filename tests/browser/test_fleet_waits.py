"""Six robots that exchange places, in a run of their own: the page shows who waits for whom."""

from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Browser, expect

from navigation.mission.mission import Station
from tests.browser.pages import Keep, OpenPage
from tests.browser.programs.live_fleet import EXCHANGE, LiveFleet, fleet_config
from tests.browser.programs.served import PATIENCE_S

pytestmark = pytest.mark.slow


@pytest.fixture
def program(browser: Browser) -> Iterator[LiveFleet]:
    with LiveFleet(fleet_config()) as program:
        yield program


def test_who_waits_for_whom_is_in_the_list_and_in_the_picture(
    open_fleet: OpenPage, program: LiveFleet, keep: Keep
) -> None:
    page = open_fleet()
    program.hold_when(lambda now: bool(now.waits_for))
    for name, (x, y) in EXCHANGE.items():
        program.people.give((Station(x, y),), name)
    waits = page.locator("[data-layer=fleet-waits] .wait-head").first
    expect(waits).to_be_attached(timeout=4000.0 * PATIENCE_S)  # they drive as slowly as the machine
    row = page.locator(".robot-row", has=page.locator(".word", has_text="Waits for")).first
    expect(row.locator(".robot-says")).to_contain_text("has to pass first")
    expect(page.locator("[data-layer=fleet-plans] .own-path")).to_have_count(5)
    expect(page.locator("[data-layer=plan] .path")).to_have_count(1)  # the chosen one's
    strokes = page.locator("[data-layer=fleet-plans] .own-path").evaluate_all(
        "paths => new Set(paths.map((path) => getComputedStyle(path).stroke)).size"
    )
    assert strokes == 5
    keep(page, "fleet_light")
