"""A press does what it is for, or the page says why not: none is lost in silence."""

import json
from collections.abc import Callable

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from navigation.dashboard.orders import cannot
from navigation.mission.mission import MissionProgress
from tests.browser.acting import click_at, send_to, wait_for_picture
from tests.browser.programs.served import ShownProgram, until

OpenPage = Callable[..., Page]
Keep = Callable[[Page, str], None]
HERE, THERE = (0.25, 0.75), (0.30, 1.50)

HOLD_BACK_PREVIEWS = """() => {
  const { connection } = clearway;
  const ask = connection.ask.bind(connection);
  globalThis.asked = 0;
  connection.ask = (message, ...rest) => {
    if (message.type !== "preview") return ask(message, ...rest);
    globalThis.asked += 1;
    return new Promise((resolve) => {
      globalThis.answerPreview = () => resolve(ask(message, ...rest));
    });
  };
}"""

HEAR_OF_NO_MISSION = """() => new Promise((resolve) => {
  const { connection } = clearway;
  const emit = connection.emit.bind(connection);
  connection.emit = (kind, message) => {
    if (kind === "state") {
      Object.assign(message, { paused: false, cannot: CANNOT });
      Object.assign(message.mission, { state: "idle", stations: [], visited: 0 });
    }
    emit(kind, message);
    if (kind === "state") resolve();
  };
})""".replace("CANNOT", json.dumps(cannot(MissionProgress())))


def have_goal(page: Page) -> None:
    click_at(page, *THERE)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    expect(page.locator("#send")).to_be_enabled()


def give_new_world(page: Page, program: ShownProgram) -> None:
    """The diagram is sent again, as after a change in the arena; until the page has it."""
    page.evaluate(
        """() => {
          globalThis.worlds = 0;
          clearway.connection.on("world", () => { globalThis.worlds += 1; });
        }"""
    )
    program.hub._roadmap = None
    page.wait_for_function("() => globalThis.worlds > 0")


@pytest.mark.parametrize("finger", [False, True])
def test_a_world_that_changes_between_press_and_release_of_send_loses_no_order(
    finger: bool, open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page(has_touch=finger)
    wait_for_picture(page)
    have_goal(page)
    page.evaluate(HOLD_BACK_PREVIEWS)  # a busy machine takes its time
    box = page.locator("#send").bounding_box()
    assert box is not None
    at = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    if finger:
        give_new_world(page, program)
        page.touchscreen.tap(*at)
    else:
        page.mouse.move(*at)
        page.mouse.down()
        give_new_world(page, program)
        page.mouse.up()
    expect(page.locator("#goal-hint")).to_be_visible()
    until(program.drives)


def test_a_world_that_changes_all_the_time_delays_no_plan(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    wait_for_picture(page)
    have_goal(page)
    page.evaluate(HOLD_BACK_PREVIEWS)
    for _ in range(3):
        give_new_world(page, program)
    assert page.evaluate("asked") == 1, "one at a time, else none would ever be answered"
    page.evaluate("answerPreview()")
    page.wait_for_function("() => asked === 2")
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")


def test_a_plan_to_earlier_stations_is_not_shown_for_new_ones(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    have_goal(page)
    page.evaluate(HOLD_BACK_PREVIEWS)
    click_at(page, *HERE)
    page.wait_for_function("() => asked === 1")
    page.evaluate("globalThis.earlier = answerPreview")
    click_at(page, *THERE)
    page.wait_for_function("() => asked === 2")
    page.evaluate("earlier()")
    page.evaluate(
        "clearway.connection.ask({ type: 'order', order: 'replan' })"
    )  # answered after it
    expect(page.locator("#goal-preview")).to_have_text("Planning…")
    page.evaluate("answerPreview()")
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")


@pytest.mark.parametrize(
    ("button", "why"),
    [
        ("send", "Not sent: there is no goal"),
        ("pause", "Nothing to pause"),
        ("resume", "Nothing to resume"),
        ("replan", "Nothing to plan again"),
        ("skip", "Nothing to skip"),
    ],
)
def test_a_button_that_cannot_work_says_why(button: str, why: str, open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    page.evaluate(HEAR_OF_NO_MISSION)
    expect(page.locator(f"#{button}")).to_be_disabled()
    page.locator(f"#{button}").click(force=True)
    expect(page.locator("#refusal-text")).to_contain_text(why)
    page.locator("#refusal-close").click()
    expect(page.locator("#refusal")).to_be_hidden()


def test_a_goal_sent_with_a_double_click_is_sent_once_and_nothing_is_refused(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    wait_for_picture(page)
    have_goal(page)
    first = program.hub.chronicle.log.next
    page.locator("#send").dblclick()
    expect(page.locator("#goal-hint")).to_be_visible()
    until(program.drives)
    expect(page.locator("#refusal")).to_be_hidden()
    log = program.hub.chronicle.log.since(first, 500)[1]
    assert sum("GO to" in line.text for line in log) == 1


def test_an_arena_just_taken_is_not_lost_to_a_state_from_before(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    page.evaluate(
        """() => {  // from the answer to "take" on: whom states name
          const { connection } = clearway;
          globalThis.named = [];
          connection.on("answer", () => { globalThis.taken = true; });
          connection.on("state", (state) => {
            if (globalThis.taken) named.push(state.seat?.name ?? null);
          });
        }"""
    )
    for _ in range(10):
        page.evaluate("taken = false; named.length = 0")
        page.locator("#seat").click()
        page.wait_for_function("() => named.length >= 2")
        assert page.evaluate("named.includes(null)") is False
        page.locator("#seat").click()
        expect(page.locator("#seat")).to_have_text("Take control")


def test_an_arena_that_somebody_else_has_just_taken_is_refused_with_a_sentence(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    wait_for_picture(page)
    program.hub.seat.take("somebody-elses-key", "Ada", program.hub.clock())
    page.keyboard.press("t")
    expect(page.locator("#refusal-text")).to_contain_text("Ada is in control")


def test_a_stop_latch_is_left_by_nothing_but_rearm_and_the_page_says_so(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    wait_for_picture(page)
    send_to(page, *THERE)
    until(program.drives)
    page.keyboard.press("Space")
    expect(page.locator("#stopped")).to_be_visible()
    page.locator("#resume").click(force=True)
    expect(page.locator("#refusal-text")).to_contain_text("re-arm it first")
    assert program.is_stopped()
