"""A recording on the page: it plays, is searched with the keyboard, and stops nothing."""

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import expect

from navigation.config.dashboard import DashboardSection
from navigation.dashboard import Dashboard
from navigation.dashboard.replay.player import Player
from navigation.dashboard.replay.replay_hub import ReplayHub
from navigation.dashboard.replay.replayed_run import ReplayedRun
from navigation.recording.tape import read_tape
from tests.browser.acting import (
    click_at,
    lose_connection,
    regain_connection,
    wait_for_picture,
)
from tests.browser.axe import serious_findings
from tests.browser.pages import Keep, OpenPage
from tests.navigation.dashboard.kept.test_replay import drive
from tests.support.runs.recordings import make_recording


@pytest.fixture
def program(tmp_path: Path) -> Iterator[Dashboard]:
    (file,) = make_recording(tmp_path, drive, picture_rate_hz=60.0)
    tape = read_tape(file)
    player = Player(tape.end_s - tape.begin_s, playing=False)
    run = ReplayedRun(tape, player, DashboardSection(port=0), time.monotonic)
    make = lambda: ReplayHub(run, clock=time.monotonic)  # noqa: E731
    with Dashboard(run, say=lambda _: None, hub=make) as page:
        yield page
    run.close()


def test_a_speed_in_a_hand_stays_when_the_connection_comes_back(open_page: OpenPage) -> None:
    page = open_page()
    expect(page.locator("#pill-text")).to_have_text("recording")
    page.keyboard.press("l")  # to the end, with charts that are sent again
    expect(page.locator("#mission-state")).to_have_text("Arrived")
    page.locator("#replay-speed").select_option("2")
    page.locator("#replay-speed").focus()
    lose_connection(page)
    regain_connection(page)
    expect(page.locator("#replay-speed")).to_have_value("2")


def test_a_recording_is_looked_at(open_page: OpenPage, keep: Keep) -> None:
    page = open_page()
    expect(page.locator("#pill-text")).to_have_text("recording")
    expect(page.locator("#stop")).to_have_text("RECORDINGstops no robot")
    expect(page.locator("#replay-play")).to_have_text("Play")
    page.keyboard.press("l")  # to the end
    expect(page.locator("#mission-state")).to_have_text("Arrived")
    wait_for_picture(page, 1)
    page.locator("#replay-seek").evaluate(
        "bar => { bar.value = 0.9; bar.dispatchEvent(new Event('change')); }"
    )
    expect(page.locator("#mission-state")).to_have_text("Driving")
    expect(page.locator("[data-layer=track] path")).to_be_attached()
    expect(page.locator("[data-layer=plan] .path")).to_be_attached()
    keep(page, "replay")
    page.keyboard.press("<")
    expect(page.locator("#replay-speed")).to_have_value("0.5")
    page.keyboard.press("p")
    expect(page.locator("#mission-state")).to_have_text("Arrived")
    expect(page.locator("#replay-play")).to_have_text("Play")
    for act in (
        lambda: page.keyboard.press("Space"),
        lambda: page.locator("#stop").click(),
        lambda: click_at(page, 1.0, 0.3),
    ):
        act()
        expect(page.locator("#refusal-text")).to_have_text(
            "This is a recording: nothing here drives or stops a robot."
        )
        page.locator("#refusal-close").click()
    expect(page.locator("#goal-title")).to_be_hidden()
    expect(page.locator("#seat")).to_be_hidden()
    expect(page.locator("#pause")).to_be_hidden()
    assert serious_findings(page) == []
