"""Earlier runs on the page: the list, one run's report and picture, a file that is saved."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import expect

from planner.roadmap.roadmap import Roadmap
from tests.browser.axe import serious_findings
from tests.browser.pages import Keep, OpenPage
from tests.browser.programs.served import ShownProgram
from tests.support.runs.shown import FakeDaemon, shown_config

TAPE = "clearway_2026-01-25_12-00-05_001.mcap"
PICTURE = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="300" height="200">'
    '<script>document.title = "not run"</script><rect width="300" height="200"/></svg>'
)


@pytest.fixture
def program(roadmap: Roadmap, tmp_path: Path) -> Iterator[ShownProgram]:
    """It has 25 earlier runs, one of them recorded."""
    for day in range(1, 26):
        folder = tmp_path / "runs" / f"2026-01-{day:02d}_12-00-00"
        folder.mkdir(parents=True)
        report = {"state": "done", "reason": "<b>there</b>", "stations": 3, "stations_visited": 3}
        (folder / "report.json").write_text(json.dumps({**report, "min_clearance_m": 0.12}))
        (folder / "track.svg").write_text(PICTURE)
    (tmp_path / "recordings").mkdir()
    (tmp_path / "recordings" / TAPE).write_bytes(bytes(range(256)) * 6000)
    config = shown_config()
    kept = {"runs_dir": tmp_path / "runs", "folder": tmp_path / "recordings"}
    recording = config.recording.model_copy(update=kept)
    config = config.model_copy(update={"recording": recording})
    with ShownProgram(FakeDaemon(config, roadmap)) as program:
        yield program


def test_an_earlier_run_is_looked_at_and_saved_with_the_keyboard(
    open_page: OpenPage, keep: Keep, tmp_path: Path
) -> None:
    page = open_page()
    page.wait_for_function("() => globalThis.clearway?.connection.isUp")
    page.keyboard.press("h")
    runs = page.locator("#history-list .run")
    expect(runs).to_have_count(20)
    expect(page.locator("#history-note")).to_have_text("20 of 25 runs")
    page.locator("#history-more").press("Enter")
    expect(runs).to_have_count(25)
    runs.first.press("Enter")
    detail = page.locator("#history-detail")
    expect(detail).to_contain_text("<b>there</b>.")
    expect(detail).to_contain_text("0.120 m")
    expect(detail.locator("img")).to_have_js_property("naturalWidth", 300)
    keep(page, "history")
    assert serious_findings(page) == []
    save = detail.get_by_role("button", name=f"Save {TAPE}")
    with page.expect_download() as download:
        save.press("Enter")
    download.value.save_as(tmp_path / "saved")
    assert (tmp_path / "saved").read_bytes() == bytes(range(256)) * 6000, "several pieces"
    expect(page).to_have_title("Ready – Clearway")  # the picture's script has not run
    page.locator("#history-open").press("h")
    expect(page.locator("#history-box")).to_be_hidden()


def test_of_several_robots_each_has_a_row_in_its_colour(
    open_page: OpenPage, keep: Keep, tmp_path: Path
) -> None:
    names = ["ada", "<i>bob</i>"]
    each = {"state": "done", "stations": 1, "stations_visited": 1, "goal_error_m": 0.004}
    report = {
        "state": "done", "reason": "ada: there", "duration_s": 31.0, "least_gap_m": 0.012,
        "least_gap_between": names, "rounds": 1, "robots": dict.fromkeys(names, each),
    }  # fmt: skip
    (tmp_path / "runs" / "2026-01-25_12-00-00" / "report.json").write_text(json.dumps(report))
    page = open_page(viewport={"width": 390, "height": 844})
    page.wait_for_function("() => globalThis.clearway?.connection.isUp")
    page.keyboard.press("h")
    run = page.locator("#history-list .run").first
    expect(run).to_contain_text("2 robots, recorded")
    run.press("Enter")
    detail = page.locator("#history-detail")
    expect(detail.locator(".reason")).to_have_text("ada: there")
    expect(detail.locator(".figures")).to_contain_text("0.012 m, ada and <i>bob</i>")
    rows = detail.locator(".each-robot tbody tr")
    expect(rows).to_have_count(2)
    expect(rows.nth(1).locator("th")).to_have_text("2<i>bob</i>")
    expect(rows.nth(1)).to_contain_text("Arrived1 of 1–")
    expect(rows.nth(1)).to_contain_text("0.004 m")
    box = detail.locator(".each-robot")
    box.focus()
    page.keyboard.press("ArrowRight")  # it is wider than a phone, and the page is not
    page.wait_for_function("box => box.scrollLeft > 0", arg=box.element_handle())
    wide, shown = page.evaluate(
        "[document.documentElement.scrollWidth, document.documentElement.clientWidth]"
    )
    assert wide <= shown
    keep(page, "fleet_history")
