"""The page of six robots in a real browser: choosing, sending, stopping all and one."""

import math
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Browser, expect

from navigation.cli.setup.check import file_problems
from navigation.config.load import load_config
from navigation.config.several.each_robot import each_robot
from navigation.dashboard.settings.desk import Around, Desk
from navigation.mission.mission import State
from tests.browser.acting import click_at, lose_connection, regain_connection
from tests.browser.axe import serious_findings
from tests.browser.pages import Keep, OpenPage
from tests.browser.programs.live import CONFIGS
from tests.browser.programs.live_fleet import LiveFleet, fleet_config
from tests.browser.programs.served import until

pytestmark = pytest.mark.slow

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
ZOOMED = {"viewport": {"width": 680, "height": 430}, "device_scale_factor": 2}
LOOKS: dict[str, dict[str, object]] = {
    "light": {},
    "dark": {"color_scheme": "dark"},
    "forced": {"forced_colors": "active"},
    "phone": PHONE,
    "zoomed": ZOOMED,
    "laptop": {"viewport": {"width": 1440, "height": 900}},
}
LAYOUT = (Path(__file__).parent / "layout.js").read_text()


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The configuration that the page may change."""
    shutil.copytree(CONFIGS, folder := tmp_path_factory.mktemp("fleet") / "etc")
    return folder / "fleet.yaml"


@pytest.fixture(scope="module")
def run(browser: Browser, file: Path) -> Iterator[LiveFleet]:
    state = file.parents[1] / "state"
    desk = Desk(Around(file, state, {}, file_problems, lambda: ([], []), reload=lambda: None))
    with LiveFleet(fleet_config(), desk) as live:
        yield live


@pytest.fixture
def program(run: LiveFleet) -> Iterator[LiveFleet]:
    """The run, in front of which each test stands alone."""
    yield run
    run.calm_down()


def test_a_robot_is_chosen_by_click_or_number_and_the_goal_is_its_own(
    open_fleet: OpenPage, program: LiveFleet
) -> None:
    page = open_fleet()
    expect(page.locator("#mission-state")).to_have_text("ada: Ready")
    assert page.locator(".robot-name").all_inner_texts() == list(program.names)
    click_at(page, *program.place("cleo"))
    expect(page.locator("#robot-cleo")).to_have_attribute("aria-pressed", "true")
    expect(page.locator("#goal-stations")).to_be_hidden()  # the press was for the robot
    expect(page.locator("#mission-state")).to_have_text("cleo: Ready")
    page.keyboard.press("5")
    expect(page.locator("#send")).to_have_text("Send eve")
    page.keyboard.press("]")
    expect(page.locator("#send")).to_have_text("Send finn")
    page.keyboard.press("1")
    page.keyboard.press("[")
    expect(page.locator("#send")).to_have_text("Send finn")
    click_at(page, 1.55, 1.35)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    page.locator("#send").click()
    until(lambda: program.state("finn") in (State.PROVING, State.PLANNING, State.DRIVING))
    (goal,) = program.daemon.robots["finn"].pilot.mission.stations
    assert math.dist((goal.x, goal.y), (1.55, 1.35)) < 0.01
    assert all(program.state(name) is State.IDLE for name in program.names if name != "finn")
    expect(page.locator("#log li", has_text="finn: GO to")).to_have_count(1)


def test_with_the_keyboard_alone_a_robot_is_chosen_sent_stopped_and_rearmed(
    open_fleet: OpenPage, program: LiveFleet, keep: Keep
) -> None:
    page = open_fleet()
    page.locator("#stage").focus()
    page.keyboard.press("2")
    for _ in range(6):
        page.keyboard.press("Shift+ArrowRight")
    page.keyboard.press("Enter")
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    keep(page, "fleet_keyboard")
    page.keyboard.press("Enter")
    until(lambda: bool(program.daemon.robots["bob"].pilot.mission.stations))
    page.locator("#robot-bob").focus()
    page.keyboard.press("Tab")  # re-arming is out of reach before it is stopped
    expect(page.locator("#stop-bob")).to_be_focused()
    page.keyboard.press("Enter")
    until(lambda: program.state("bob") is State.STOPPED)
    assert all(program.state(name) is not State.STOPPED for name in program.names if name != "bob")
    expect(page.locator("#rearm-bob")).to_have_attribute("aria-disabled", "false")
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Enter")
    until(lambda: program.state("bob") is State.IDLE)


def test_the_big_stop_stops_all_and_is_left_for_each_or_for_all(
    open_fleet: OpenPage, program: LiveFleet
) -> None:
    page = open_fleet()
    expect(page.locator("#stop")).to_contain_text("STOP all")
    page.keyboard.press("Space")
    until(lambda: all(program.state(name) is State.STOPPED for name in program.names))
    expect(page.locator(".robot-row .word", has_text="Stopped")).to_have_count(6)
    expect(page.locator("#rearm-dan")).to_have_attribute("aria-disabled", "false")
    page.locator("#resume-all").click(force=True)  # no order but one to re-arm leaves a stop
    expect(page.locator("#refusal")).to_contain_text("Nothing to resume")
    page.locator("#rearm-dan").click()
    until(lambda: program.state("dan") is State.IDLE)
    assert all(program.state(name) is State.STOPPED for name in program.names if name != "dan")
    page.locator("#rearm-all").click()
    until(lambda: all(program.state(name) is State.IDLE for name in program.names))


def test_one_robot_s_settings_are_changed_with_the_keyboard_at_rest_only(
    open_fleet: OpenPage, program: LiveFleet, file: Path, keep: Keep
) -> None:
    page = open_fleet()
    page.locator("#settings-open").focus()
    page.keyboard.press("Enter")
    page.locator("#settings-find").fill("bob")
    radius = page.locator("[data-key='robots[1].radius_m'] input")
    expect(radius).to_be_visible()
    expect(page.locator("[data-key='robots[0].radius_m']")).to_be_hidden()
    expect(radius).to_have_attribute("placeholder", "0.07")
    radius.fill("-1")
    problem = page.locator("[data-key='robots[1].radius_m'] .problem")
    expect(problem).to_contain_text("must be > 0")
    keep(page, "fleet_settings")
    radius.fill("0.075")
    expect(problem).to_have_text("")
    page.locator("#settings-find").fill("")
    marker = page.locator("[data-key='robots[0].marker_id'] input")
    page.locator("summary", has_text="robots: ada").press("Enter")
    marker.fill("3")
    clash = page.locator("[data-key='robots[2].marker_id'] .problem")
    expect(clash).to_contain_text("already")  # its section has opened
    expect(clash).to_be_visible()
    marker.fill("1")
    expect(clash).to_be_empty()
    save = page.locator("#settings-save")
    expect(save).to_have_attribute("aria-disabled", "false")
    program.people.stop("somebody works here", "dan")
    save.press("Enter")
    expect(page.locator("#settings-said")).to_contain_text("no mission is under way")
    program.people.resume("dan")
    until(lambda: program.state("dan") is State.IDLE)
    save.press("Enter")
    expect(page.locator("#settings-said")).to_contain_text("Saved robots[1].radius_m")
    assert each_robot(load_config(file, {}))["bob"].robot.radius_m == 0.075
    page.locator("#settings-undo").press("Enter")
    expect(page.locator("#settings-said")).to_contain_text("is undone")
    assert each_robot(load_config(file, {}))["bob"].robot.radius_m == 0.07
    page.keyboard.press("Escape")
    expect(page.locator("#settings")).to_be_hidden()


@pytest.mark.parametrize("look", list(LOOKS))
def test_nothing_is_cut_off_or_covered_however_the_page_is_looked_at(
    look: str, open_fleet: OpenPage, program: LiveFleet, keep: Keep
) -> None:
    page = open_fleet(**LOOKS[look])
    program.people.stop("looked at", "finn")
    expect(page.locator("#rearm-finn")).to_be_visible()
    keep(page, f"fleet_{look}")
    if look in ("light", "phone"):
        assert serious_findings(page) == []
    if look in ("laptop", "phone"):
        assert page.evaluate(LAYOUT) == []
    wide, shown = page.evaluate(
        "[document.documentElement.scrollWidth, document.documentElement.clientWidth]"
    )
    assert wide <= shown
    places = {}
    for name in ("robot-finn", "rearm-finn", "stop-finn", "pause-all", "rearm-all"):
        button = page.locator(f"#{name}")
        button.scroll_into_view_if_needed()
        box = button.bounding_box()
        assert box is not None
        assert min(box["width"], box["height"]) >= 24.0, name  # WCAG 2.2, 2.5.8
        places[name] = box
    rearm, stop = places["rearm-finn"], places["stop-finn"]
    assert stop["y"] + stop["height"] <= rearm["y"], "one above the other"
    word = page.locator("#robot-finn .word").bounding_box()
    assert word is not None
    assert word["width"] > 50.0  # it says what is the matter


def test_a_stop_button_in_a_hand_stays_when_the_connection_comes_back(open_fleet: OpenPage) -> None:
    page = open_fleet()
    page.locator("#stop-finn").focus()
    held = page.locator("#stop-finn").element_handle()
    lose_connection(page)
    regain_connection(page)
    assert held.evaluate("(button) => button === document.activeElement")


def test_a_zone_is_drawn_for_one_robot_and_a_press_on_another_chooses_nobody(
    open_fleet: OpenPage, program: LiveFleet, keep: Keep
) -> None:
    page = open_fleet()
    page.locator("#zones-open").click()
    page.locator("#zones-new").click()
    page.locator("#zone-kind").select_option("wait")
    page.locator("#zone-shape").select_option("circle")
    page.get_by_role("checkbox", name="eve").check()
    click_at(page, *program.place("cleo"))
    page.locator("#zone-size").fill("0.05")
    keep(page, "fleet_zone")
    expect(page.locator("#robot-ada")).to_have_attribute("aria-pressed", "true")
    page.locator("#zone-save").click()
    expect(page.locator("#zones-list li")).to_have_text(["wait-1no waiting; for eveEdit×"])
    expect(page.locator("[data-layer=zones] .zone-wait")).to_be_attached()
    page.get_by_label("Delete wait-1").click()
    expect(page.locator("#zones-list li")).to_have_count(0)
