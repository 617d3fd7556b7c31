"""A recording of several robots on the page: all of them, who waits for whom, and no orders."""

import time
from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import expect

from navigation.config.dashboard import DashboardSection
from navigation.dashboard import Dashboard
from navigation.dashboard.replay.player import Player
from navigation.dashboard.replay.replay_hub import ReplayHub
from navigation.dashboard.replay.replayed_run import ReplayedRun
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.recording.tape import Tape, read_tape
from tests.browser.pages import Keep, OpenPage
from tests.support.runs.recordings import record_alcove

pytestmark = pytest.mark.slow

LOOKS: dict[str, dict[str, object]] = {
    "light": {},
    "dark": {"color_scheme": "dark"},
    "forced": {"forced_colors": "active"},
    "phone": {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True},
    "zoomed": {"viewport": {"width": 680, "height": 430}, "device_scale_factor": 2},
}
AFTER_S = 1.0


@pytest.fixture(scope="module")
def tape(tmp_path_factory: pytest.TempPathFactory) -> Tape:
    """Until a second after one of the two has begun to wait for the other."""
    began_s: list[float] = []

    def until(_daemon: Daemon, now: RunState) -> bool:
        if now.waits_for:
            began_s.append(now.time_s)
        return bool(began_s) and now.time_s > began_s[0] + AFTER_S

    (file,) = record_alcove(tmp_path_factory.mktemp("alcove"), until)
    return read_tape(file)


@pytest.fixture
def program(tape: Tape) -> Iterator[Dashboard]:
    player = Player(tape.end_s - tape.begin_s, playing=False)
    player.seek(time.monotonic(), 1.0)  # the very first picture has no robot yet
    run = ReplayedRun(tape, player, DashboardSection(port=0), time.monotonic)
    make = lambda: ReplayHub(run, clock=time.monotonic)  # noqa: E731
    with Dashboard(run, say=lambda _: None, hub=make) as page:
        yield page
    run.close()


def test_all_robots_are_replayed_with_the_keyboard_and_none_is_stopped(
    tape: Tape, open_page: OpenPage, keep: Keep
) -> None:
    page = open_page()
    expect(page.locator("#stop")).to_have_text("RECORDINGstops no robot")
    expect(page.locator(".robot-name")).to_have_text(["left", "right"])
    page.keyboard.press("Shift+L")  # to the end: one waits for the other
    (waiting,) = tape.waits[-1][1][1]
    other = tape.waits[-1][1][1][waiting]
    expect(page.locator(f"#robot-{waiting} .word")).to_have_text(f"Waits for {other}")
    expect(page.locator(f"#robot-{waiting} .robot-says")).to_contain_text("has to pass first")
    expect(page.locator(f"#robot-{other} .word")).to_have_text("Driving")
    arrow = page.locator("[data-layer=fleet-waits] .wait")
    expect(arrow).to_have_attribute("data-robot", waiting)
    expect(page.locator("[data-layer=fleet-bodies] .own-robot")).to_have_count(2)
    expect(page.locator("[data-layer=fleet-tracks] path[d^=M]")).to_have_count(2)
    expect(page.locator("[data-layer=fleet-plans] .own-path")).to_have_count(1)
    expect(page.locator("[data-layer=plan] .path")).to_have_count(1)  # the chosen one's
    expect(page.locator("#log li", has_text="left: driving").first).to_be_attached()
    keep(page, "fleet_replay")
    page.keyboard.press("2")
    expect(page.locator("#mission-state")).to_contain_text("right: ")
    page.keyboard.press("Shift+J")  # to the beginning
    expect(arrow).to_have_count(0)
    expect(page.locator("#replay-time")).to_contain_text("0:00 of")
    for name in ("#stop-left", "#rearm-left", "#pause-all", "#send", "#settings-open"):
        expect(page.locator(name)).to_be_hidden()
    page.keyboard.press("Space")
    expect(page.locator("#refusal-text")).to_have_text(
        "This is a recording: nothing here drives or stops a robot."
    )
    page.locator("#refusal-close").click()
    page.keyboard.press(">")
    expect(page.locator("#replay-speed")).to_have_value("2")
    page.keyboard.press("p")
    expect(page.locator(f"#robot-{waiting} .word")).to_have_text(f"Waits for {other}")


@pytest.mark.parametrize("look", list(LOOKS))
def test_nothing_of_a_replay_is_cut_off_however_it_is_looked_at(
    look: str, open_page: OpenPage, keep: Keep
) -> None:
    page = open_page(**LOOKS[look])
    expect(page.locator("[data-layer=fleet-bodies] .own-robot")).to_have_count(2)
    keep(page, f"fleet_replay_{look}")
    wide, shown = page.evaluate(
        "[document.documentElement.scrollWidth, document.documentElement.clientWidth]"
    )
    assert wide <= shown
    expect(page.locator("#pill-text")).to_have_text("recording")
    if look != "phone":  # where the sign is at the bottom
        theme, sign = (page.locator(name).bounding_box() for name in ("#theme", "#stop"))
        assert theme is not None
        assert sign is not None
        assert theme["x"] + theme["width"] <= sign["x"]
    cut = "text => text.scrollWidth > text.clientWidth"
    assert not page.locator("#pill-text").evaluate(cut)
    for name in ("#replay-play", "#replay-seek", "#replay-speed", "#robot-left", "#robot-right"):
        control = page.locator(name)
        control.scroll_into_view_if_needed()
        box = control.bounding_box()
        assert box is not None
        assert min(box["width"], box["height"]) >= 24.0, name  # WCAG 2.2, 2.5.8
