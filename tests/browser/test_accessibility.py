"""axe-core finds nothing serious on the page, whatever it shows; and the legend can be seen.

Settings, calibration, earlier runs, recordings and several robots: where they are tested.
"""

from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import expect

from tests.browser.acting import click_at, wait_for_picture
from tests.browser.axe import serious_findings
from tests.browser.pages import AWAY, HERE, OpenPage, drive
from tests.browser.programs.served import ShownProgram
from tests.browser.test_zones import have_zones

LEAST_CONTRAST = 3.0
"""Of what is drawn: Web Content Accessibility Guidelines 2.2, 1.4.11."""


@pytest.mark.parametrize("width", [390, 1440])
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_serious(
    theme: str, width: int, open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page(
        color_scheme=theme,
        viewport={"width": width, "height": 850},
        allowed=AWAY,
    )
    wait_for_picture(page)
    found = serious_findings(page)
    for name in ("layers", "legend", "keys"):
        page.locator(f"#{name}-open").dispatch_event("click")  # a phone has no list of keys
        expect(page.locator(f"#{name}")).to_be_visible()
        found += serious_findings(page)
    have_zones(program)
    page.locator("#zones-open").dispatch_event("click")
    expect(page.locator("#zones-list li")).to_have_count(5)
    found += serious_findings(page)
    page.keyboard.press("Escape")  # the list of keys
    page.get_by_label("Edit fast").dispatch_event("click")
    page.locator("#zone-cost").fill("cheap")
    page.locator("#zone-save").dispatch_event("click")
    expect(page.locator("#zone-error")).not_to_be_empty()
    found += serious_findings(page)
    page.reload()  # with nothing open
    wait_for_picture(page)
    drive(program, page)
    click_at(page, *HERE)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    found += serious_findings(page)
    program.daemon.people.stop("stopped by a test")
    expect(page.locator("#stopped")).to_be_visible()
    found += serious_findings(page)
    program.take_away()
    expect(page.locator("#lost")).to_be_visible()
    found += serious_findings(page)
    assert found == []


def test_axe_finds_nothing_serious_where_a_token_is_asked_for(
    open_page: OpenPage, program: ShownProgram
) -> None:
    program.bring_back(token="a-token-of-some-length")
    page = open_page(allowed=rf"Authentication|status of 40[13]|response code: 403|{AWAY}")
    expect(page.locator("#token-form")).to_be_visible()
    assert serious_findings(page) == []


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_every_sample_of_the_legend_is_seen(theme: str, open_page: OpenPage) -> None:
    page = open_page(color_scheme=theme)
    wait_for_picture(page)
    page.locator("#legend-open").click()
    best = page.evaluate((Path(__file__).parent / "samples.js").read_text())
    assert len(best) >= 16
    assert {words: seen for words, seen in best.items() if seen < LEAST_CONTRAST} == {}
