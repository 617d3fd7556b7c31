"""The pictures of the documentation, made by the program: ``make pictures``.

    python -m tests.browser.pictures

Writes docs/pictures/dashboard.png and fleet.png, runs of one robot and of six seen through the
page, and docs/pictures/plan.svg, what `clearway plan --render` draws. Needs Chromium, as the
browser tests do.
"""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Page, expect, sync_playwright

from navigation.mission.mission import Station
from tests.browser.acting import click_at, drag, wait_for_picture
from tests.browser.conftest import ARGUMENTS, CHROMIUM
from tests.browser.programs.live import CONFIGS, Live, live_config
from tests.browser.programs.live_fleet import EXCHANGE, LiveFleet, fleet_config
from tests.support.pictures import call
from tests.support.waiting import wait_until

FOLDER = Path(__file__).parents[2] / "docs" / "pictures"
ARENA = CONFIGS / "arenas" / "laboratory.txt"
LARGEST_BYTES = 300 * 1024


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    draw_plan(FOLDER / "plan.svg")
    photograph(FOLDER / "dashboard.png")
    photograph_fleet(FOLDER / "fleet.png")
    for file in sorted(FOLDER.iterdir()):
        size = file.stat().st_size
        assert size <= LARGEST_BYTES, f"{file}: {size} bytes: must be at most {LARGEST_BYTES}"
        print(f"{file.relative_to(FOLDER.parents[1])}: {size} bytes")


def draw_plan(file: Path) -> None:
    """What the command line draws."""
    places = ("--start", "0.2,0.2", "--goal", "2.2,1.6,90", "--radius", "0.09")
    told = call(
        "plan", ARENA, *places, "--margin", "0.015", "--alternatives", "1", "--render", file
    )
    assert told.code == 0, told


def photograph(file: Path) -> None:
    """The page in the middle of a run, without the camera's noise, which packs badly."""
    with Live(live_config(noise_grey=0.0)) as live, sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        page = chromium.new_page(viewport={"width": 1440, "height": 900})
        page.goto(live.url)
        wait_for_picture(page)
        send_on_a_tour(page)
        page.mouse.move(2, 400)
        assert wait_until(lambda: live.place()[1] > 1.3, 90.0)
        assert wait_until(lambda: live.drives() and taken(page, file, live), 30.0)
        chromium.close()


def photograph_fleet(file: Path) -> None:
    """Six robots that exchange places, when one waits for another."""
    with (
        LiveFleet(fleet_config(noise_grey=0.0), pictures=True) as live,
        sync_playwright() as playwright,
    ):
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        page = chromium.new_page(viewport={"width": 1440, "height": 900})
        page.goto(live.url)
        live.hold_when(lambda now: bool(now.waits_for))
        for name, (x, y) in EXCHANGE.items():
            live.people.give((Station(x, y),), name)
        expect(page.locator("[data-layer=fleet-waits] .wait-head").first).to_be_attached()
        page.keyboard.press("3")
        page.screenshot(path=file)
        chromium.close()


def taken(page: Page, file: Path, live: Live) -> bool:
    """Take the picture; whether the robot drove all the while, on a busy machine too."""
    expect(page.locator("#mission-state")).to_have_text("Driving")
    page.screenshot(path=file)
    return live.drives()


def send_on_a_tour(page: Page) -> None:
    """Past the bucket, and on to the far corner."""
    click_at(page, 0.72, 1.52)
    page.keyboard.down("Shift")
    drag(page, (2.20, 1.60), (2.20, 1.75))
    page.keyboard.up("Shift")
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    page.locator("#send").click()


if __name__ == "__main__":
    main()
