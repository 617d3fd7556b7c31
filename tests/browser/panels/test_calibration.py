"""The camera calibrated from the page: a simulated hand holds the board, a person saves.

The command's page is the same, without what starts, saves and cancels."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from navigation.cli.calibrating.page import LivePage
from navigation.dashboard import Bench
from navigation.run.anchoring import take_over_lens
from tests.browser.acting import start_calibration
from tests.browser.axe import serious_findings
from tests.browser.programs.served import PATIENCE_S, ShownProgram, until
from tests.support.runs.held_board import VirtualTime, small_config, states
from vision.calibrate.lens import Lens
from vision.calibration.calibration_file import load_calibration, load_lens
from vision.camera.camera import Image

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]
Keep = Callable[[Page, str], None]


class HeldTime(VirtualTime):
    """Virtual time that waits, once a view was taken, until it may pass."""

    def __init__(self) -> None:
        super().__init__()
        self.bench: Bench | None = None
        self.may_pass = threading.Event()

    def wait(self, seconds: float) -> None:
        super().wait(seconds)
        if self.bench is not None and self.bench.facts()["remarks"]:
            assert self.may_pass.wait(PATIENCE_S)


@pytest.fixture
def time() -> HeldTime:
    return HeldTime()


@pytest.fixture
def bench(program: ShownProgram, time: HeldTime, tmp_path: Path) -> Iterator[Bench]:
    """What the page calibrates; a lens goes into the test's folder."""
    config = small_config(noise_grey=0.0)
    assert config.camera.calibration is not None
    calibration = load_calibration(config.camera.calibration)
    camera = config.camera.model_copy(update={"calibration": tmp_path / "arena.yaml"})
    named = config.model_copy(update={"camera": camera})
    now = datetime(2026, 1, 2)

    def save(lens: Lens, picture: Image | None) -> str:
        return take_over_lens(named, lens, picture, now, None)

    bench = Bench(program.daemon, config, calibration, save, time.clock, time.wait)
    time.bench = bench
    program.bring_back(bench=bench)
    yield bench
    time.may_pass.set()
    bench.close()


def test_a_lens_is_found_on_the_page_and_saved(
    open_page: OpenPage,
    program: ShownProgram,
    time: HeldTime,
    bench: Bench,
    tmp_path: Path,
    keep: Keep,
) -> None:
    page = open_page()
    start_calibration(page)
    expect(page.locator("#calibration-said")).to_contain_text("Hold the board")
    expect(page.locator("#calibration-overlay .asked-line")).to_have_count(1)
    expect(page.locator("#calibration-remarks")).to_contain_text("View 1: taken")
    keep(page, "calibration")
    assert serious_findings(page) == []
    time.may_pass.set()
    expect(page.locator("#calibration-said")).to_contain_text("Found: ", timeout=180_000)
    keep(page, "calibration_found")
    page.locator("#calibration-save").click()
    expect(page.locator("#calibration-said")).to_contain_text("is saved as arena.lens.20260102")
    lens = load_lens(tmp_path / "arena.lens.20260102-000000.yaml")
    assert math.isclose(lens.camera_matrix[0, 0], 617.0, rel_tol=0.01)
    assert program.daemon.lent is None


@pytest.mark.parametrize("size", [(1400, 900), (390, 844), (700, 450)])
def test_stop_is_never_covered_by_the_calibration(
    open_page: OpenPage, program: ShownProgram, bench: Bench, size: tuple[int, int], keep: Keep
) -> None:
    page = open_page(viewport={"width": size[0], "height": size[1]})
    start_calibration(page)
    keep(page, f"calibration_{size[0]}")
    page.locator("#stop").click()
    until(program.is_stopped)


def test_the_page_of_the_command_shows_the_same_and_only_looks(
    open_page: OpenPage, keep: Keep
) -> None:
    with LivePage(0) as live:
        page = open_page(live.url)
        expect(page.locator("#calibration-said")).to_have_text("Waiting for a picture.")
        for state, frame in states(26):
            live.show(state, frame)
        expect(page.locator("#calibration-said")).to_contain_text("Hold the board")
        expect(page.locator("#calibration-overlay .asked-line")).to_have_count(1)
        expect(page.locator("#calibration-remarks li")).to_have_text(
            ["View 2: taken", "View 1: taken"]
        )
        expect(page.locator(":is(button, input, select):visible")).to_have_count(0)
        keep(page, "calibration_of_the_command")
        assert serious_findings(page) == []
        live.end("enough views")
        expect(page.locator("#calibration-phase")).to_have_text("ended")
    expect(page.locator("#calibration-said")).to_have_text("Enough views.")


def test_the_page_of_a_command_that_is_gone_says_so(open_page: OpenPage) -> None:
    with LivePage(0) as live:
        page = open_page(live.url, allowed="Failed to load resource")
        expect(page.locator("#calibration-said")).to_have_text("Waiting for a picture.")
    expect(page.locator("#calibration-said")).to_contain_text("The program has ended, or is not")
