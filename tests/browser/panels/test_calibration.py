"""The camera calibrated from the page: a simulated hand holds the board, a person saves."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from navigation.control.orders import carry_out
from navigation.dashboard import Bench
from navigation.mission.mission import State
from navigation.run.anchoring import take_over_lens
from tests.browser.acting import wait_for_picture
from tests.browser.live import Live
from tests.support.runs.held_board import small_config
from tests.support.waiting import wait_until
from vision.calibration.calibration_file import load_lens

pytestmark = pytest.mark.timed  # the board is moved in real time

OpenPage = Callable[..., Page]
Keep = Callable[[Page, str], Path]


@pytest.fixture
def bench(live: Live, tmp_path: Path) -> Iterator[Bench]:
    """What the page calibrates; a lens goes into the test's folder."""
    config = small_config()
    camera = config.camera.model_copy(update={"calibration": tmp_path / "arena.yaml"})
    named = config.model_copy(update={"camera": camera})
    now = datetime(2026, 1, 2)
    live.take_away()
    bench = live.serve_calibration(
        config, lambda lens, picture: take_over_lens(named, lens, picture, now, None)
    )
    live.bring_back()
    yield bench
    bench.close()


def open_and_start(page: Page) -> None:
    wait_for_picture(page)
    page.locator("#calibration-open").click()
    page.locator("#board-squares").fill("8x6")
    page.locator("#board-square_mm").fill("100")
    page.locator("#board-marker_mm").fill("75")
    page.locator("#board-dictionary").fill("DICT_5X5_100")
    page.locator("#calibration-start").click()
    expect(page.locator("#calibration-view")).to_be_visible()


def test_a_lens_is_found_on_the_page_and_saved(
    open_page: OpenPage, live: Live, bench: Bench, tmp_path: Path, keep: Keep
) -> None:
    page = open_page()
    open_and_start(page)
    expect(page.locator("#calibration-said")).to_contain_text("Hold the board")
    expect(page.locator("#calibration-overlay .asked-line")).to_have_count(1)
    expect(page.locator("#calibration-last")).to_contain_text("View 1: taken")
    keep(page, "calibration")
    expect(page.locator("#calibration-said")).to_contain_text("Found: ", timeout=180_000)
    keep(page, "calibration_found")
    page.locator("#calibration-save").click()
    expect(page.locator("#calibration-said")).to_contain_text("is saved as arena.lens.20260102")
    lens = load_lens(tmp_path / "arena.lens.20260102-000000.yaml")
    assert math.isclose(lens.camera_matrix[0, 0], 617.0, rel_tol=0.01)
    assert live.daemon.lent is None


def test_the_robot_takes_no_order_until_it_is_cancelled_and_stop_works_all_the_time(
    open_page: OpenPage, live: Live, bench: Bench
) -> None:
    page = open_page()
    open_and_start(page)
    refused = carry_out({"order": "go", "stations": [{"x_m": 1.8, "y_m": 0.5}]}, live.daemon)
    assert refused == {"ok": False, "error": "the camera is being calibrated from the page"}
    page.locator("#stop").click()
    assert wait_until(lambda: live.state is State.STOPPED)
    assert wait_until(lambda: live.daemon.link.snapshot().estopped)
    page.locator("#calibration-cancel").click()
    expect(page.locator("#calibration-said")).to_contain_text("Cancelled: nothing was written")
    expect(page.locator("#calibration-board")).to_be_visible()
    assert live.daemon.lent is None
    page.locator("#calibration-start").click()
    expect(page.locator("#calibration-said")).to_contain_text("re-arm the robot first")


@pytest.mark.parametrize("size", [(1400, 900), (390, 844), (700, 450)])
def test_stop_is_never_covered_by_the_calibration(
    open_page: OpenPage, live: Live, bench: Bench, size: tuple[int, int], keep: Keep
) -> None:
    page = open_page(viewport={"width": size[0], "height": size[1]})
    open_and_start(page)
    keep(page, f"calibration_{size[0]}")
    page.locator("#stop").click()
    assert wait_until(lambda: live.state is State.STOPPED)
