"""The dashboard in a real browser: goals, keys, looks and tokens."""

import math
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import expect

from navigation.mission.mission import State
from tests.browser.acting import click_at, drag, on_screen, wait_for_picture
from tests.browser.pages import AWAY, HERE, THERE, Keep, OpenPage
from tests.browser.programs.served import ShownProgram, until


def test_the_cursor_tells_clearance_and_whether_the_robot_fits(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    page.mouse.move(*on_screen(page, 0.20, 0.90))
    probe = page.locator("#probe")
    expect(probe).to_contain_text("the robot fits")
    told = float((probe.text_content() or "").split("clearance ")[1].split(" m")[0])
    assert told == pytest.approx(min(0.20, math.dist((0.20, 0.90), (0.42, 1.16)) - 0.13), abs=0.004)
    page.mouse.move(*on_screen(page, 0.42, 1.16))
    expect(probe).to_contain_text("inside an obstacle")
    page.mouse.move(*on_screen(page, 0.05, 0.90))
    expect(probe).to_contain_text("too tight for the robot")


def test_a_drag_sets_the_heading_and_shift_adds_stations(open_page: OpenPage, keep: Keep) -> None:
    page = open_page()
    wait_for_picture(page)
    click_at(page, 0.20, 0.90)
    page.keyboard.down("Shift")
    drag(page, (0.30, 1.55), (0.60, 1.55))
    page.keyboard.up("Shift")
    expect(page.locator("#goal-stations li")).to_have_count(2)
    expect(page.locator("#goal-stations li").nth(1)).to_contain_text("0°")
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    keep(page, "stations")
    page.keyboard.press("Escape")
    expect(page.locator("#goal-stations")).to_be_hidden()


def test_where_no_way_leads_the_page_says_why(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    click_at(page, 0.42, 1.16)
    expect(page.locator("#goal-preview")).to_contain_text("No plan:")
    expect(page.locator("#send")).to_be_disabled()


def test_the_whole_way_goes_by_keyboard(open_page: OpenPage, program: ShownProgram) -> None:
    page = open_page()
    wait_for_picture(page)
    page.locator("#stage").focus()
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("Shift+ArrowUp")
    expect(page.locator("#probe")).to_contain_text("x 1.180  y 1.000 m")
    page.keyboard.press("Enter")
    page.keyboard.press(",")
    expect(page.locator("#goal-stations li")).to_have_text("1.18, 1.00 m, 15°")
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    expect(page.locator("#send")).to_be_enabled()
    page.keyboard.press("Enter")
    expect(page.locator("#mission-state")).to_have_text("Driving")
    stations = program.daemon.mission.stations
    assert (stations[-1].x, stations[-1].y) == (1.18, 1.0)
    assert stations[-1].heading_rad == pytest.approx(math.radians(15))


def test_enter_before_the_plan_is_there_says_that_nothing_was_sent(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    wait_for_picture(page)
    page.locator("#stage").focus()
    page.keyboard.press("Shift+ArrowLeft")
    page.evaluate(
        """() => {  // both within one task of the page: no answer can come between
          for (let time = 0; time < 2; time += 1) {
            document.getElementById("stage").dispatchEvent(
              new KeyboardEvent("keydown", { key: "Enter", bubbles: true }));
          }
        }"""
    )
    expect(page.locator("#refusal")).to_contain_text("Not sent: the plan is not there yet")
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    assert program.state is not State.DRIVING
    page.keyboard.press("Enter")
    until(program.drives)
    expect(page.locator("#refusal")).to_be_hidden()


def test_a_plan_can_be_sent_before_a_state_tells_whose_the_arena_is(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    page.evaluate(  # states stop; answers to orders go on
        """() => {
          const { connection } = globalThis.clearway;
          const emit = connection.emit.bind(connection);
          connection.emit = (kind, ...rest) => { if (kind !== "state") emit(kind, ...rest); };
        }"""
    )
    click_at(page, *THERE)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    expect(page.locator("#send")).to_be_enabled()


def test_layers_can_be_switched_off_and_stay_so(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)
    road = page.locator("[data-layer=roadmap]")
    expect(road).to_be_visible()
    expect(page.locator("#layers-count")).to_have_text("8 of 10")
    page.locator("#layers-open").click()
    page.get_by_label("Roadmap").uncheck()
    expect(road).to_be_hidden()
    expect(page.locator("#layers-count")).to_have_text("7 of 10")
    page.keyboard.press("Escape")
    expect(page.locator("#layers")).to_be_hidden()
    expect(page.locator("#layers-open")).to_be_focused()
    page.keyboard.press("3")
    expect(page.locator("[data-layer=diagram]")).to_be_hidden()
    page.keyboard.press("3")
    expect(page.locator("[data-layer=diagram]")).to_be_visible()
    page.reload()
    wait_for_picture(page)
    expect(road).to_be_hidden()


def test_it_works_on_a_phone(open_page: OpenPage, keep: Keep) -> None:
    page = open_page(
        viewport={"width": 390, "height": 844},
        has_touch=True,
        is_mobile=True,
        device_scale_factor=2,
    )
    wait_for_picture(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    box = page.locator("#stop").bounding_box()
    assert box is not None
    assert box["y"] + box["height"] <= 844, "STOP is on the screen"
    assert box["width"] > 300
    assert box["height"] > 60
    page.touchscreen.tap(*on_screen(page, *HERE))
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    keep(page, "phone")
    send = page.locator("#send").bounding_box()
    assert send is not None
    assert send["y"] + send["height"] < box["y"], "what sends it is in sight"
    page.locator("#health").scroll_into_view_if_needed()
    after = page.locator("#stop").bounding_box()
    assert after is not None
    assert after["y"] == pytest.approx(box["y"], abs=2), "STOP stays where it is"
    keep(page, "phone_health")


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_every_text_has_contrast_enough(theme: str, open_page: OpenPage, keep: Keep) -> None:
    page = open_page(color_scheme=theme)
    wait_for_picture(page)
    click_at(page, *HERE)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    keep(page, f"{theme}_preview")
    poor = page.evaluate((Path(__file__).parent / "contrast.js").read_text())
    assert poor == []
    page.keyboard.press("Space")
    expect(page.locator("#stopped")).to_be_visible()
    expect(page.locator("#rearm")).to_be_enabled()
    assert page.evaluate((Path(__file__).parent / "contrast.js").read_text()) == []
    keep(page, f"{theme}_stopped")


def test_a_token_opens_the_page_and_leaves_the_address(
    open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    token = "a-token-of-some-length"
    refused = rf"Authentication|status of 40[13]|response code: 403|{AWAY}"
    program.bring_back(token=token)
    page = open_page(allowed=refused)
    expect(page.locator("#token-form")).to_be_visible()
    keep(page, "token")
    page.locator("#token").fill("a-wrong-token-of-length")
    page.locator("#token-form button").click()
    expect(page.locator("#token-form")).to_be_visible()
    page.locator("#token").fill(token)
    page.locator("#token-form button").click()
    wait_for_picture(page)
    page = open_page(f"{program.url}#token={token}")
    wait_for_picture(page)
    assert page.url == program.url, "the token does not stay in the address"
    page.reload()
    wait_for_picture(page)


def test_the_printed_link_drives_and_without_its_token_one_only_looks(
    open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    token = "the-programs-own-token-32-letters"
    program.bring_back(own_token=token)
    page = open_page(allowed=r"status of 401")
    wait_for_picture(page)
    expect(page.locator("#seat-text")).to_have_text("Looking only")
    page.keyboard.press("Space")
    expect(page.locator("#refusal-text")).to_contain_text("driving need the token")
    expect(page.locator("#token-form")).to_be_visible()
    keep(page, "visitor")
    assert program.daemon.orders == []
    page.locator("#token").fill(token)
    page.locator("#token-form button").click()
    expect(page.locator("#token-form")).to_be_hidden()
    expect(page.locator("#seat-text")).not_to_have_text("Looking only")
    page.keyboard.press("Space")
    expect(page.locator("#stopped")).to_be_visible()
    printed = program.said[-1].removeprefix("dashboard at ")
    page = open_page(printed)
    wait_for_picture(page)
    expect(page.locator("#stopped")).to_be_visible()
    expect(page.locator("#rearm")).to_be_enabled()
    page.locator("#rearm").click()
    expect(page.locator("#stopped")).to_be_hidden()
