"""What only a running program can show on its page: one run, which each test leaves as it was.

The robot is simulated, and so is its time: a busy computer makes the run slower, nothing else.
"""

import math
from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Browser, Page, expect

from navigation.dashboard import Bench
from navigation.mission.mission import State
from navigation.orders.carry_out import carry_out
from tests.browser.acting import click_at, send_to, start_calibration, wait_for_picture
from tests.browser.pages import HERE, THERE, Keep, OpenPage
from tests.browser.programs.live import Live, live_config
from tests.browser.programs.served import until
from tests.support.runs.held_board import small_config

pytestmark = pytest.mark.slow

WITHIN_THE_MARGIN = (0.097, 0.75)
"""Between the radius of 0.09 m and the margin of 0.015 m from the arena's edge."""
GIVEN_UP = "the margin of 0.015 m is given up"


@pytest.fixture(scope="module")
def run(browser: Browser) -> Iterator[Live]:
    with Live(live_config(light=True)) as run:
        yield run


@pytest.fixture
def program(run: Live) -> Iterator[Live]:
    """The run, in front of which each test stands alone."""
    yield run
    run.calm_down()


@pytest.fixture
def bench(program: Live) -> Iterator[Bench]:
    """A bench on the page; a test asks for it before its pages, which are then closed first."""
    clock, wait = program.world.clock, program.world.wait
    calibration = program.world.calibration
    bench = Bench(program.daemon, small_config(), calibration, lambda *_: "", clock, wait)
    program.bring_back(bench=bench)
    yield bench
    bench.close()
    program.bring_back()


def set_off(program: Live, page: Page) -> None:
    """Send the robot to whichever of two places is farther, and wait until it moves."""
    x, y, _ = program.place()
    send_to(page, *max(HERE, THERE, key=lambda place: math.dist(place, (x, y))))
    until(lambda: program.drives() and program.is_moving())


def test_the_page_shows_the_arena_and_the_picture_moves(open_page: OpenPage, keep: Keep) -> None:
    page = open_page()
    wait_for_picture(page)
    first = page.evaluate("document.getElementById('picture').toDataURL()")
    wait_for_picture(page, page.evaluate("clearway.picture.count") + 3)
    assert page.evaluate("document.getElementById('picture').toDataURL()") != first
    assert len(page.locator("[data-layer=obstacles] .obstacle").get_attribute("d") or "") > 200
    expect(page.locator("#pill-text")).to_have_text("live")
    expect(page.locator("#health-camera .word")).to_have_text("running")
    expect(page.locator("#health-link .word")).to_have_text("up")
    expect(page.locator("#log li")).not_to_have_count(0)
    assert page.locator("#health-camera path.line").get_attribute("d")
    keep(page, "first_look")


def test_what_is_drawn_lies_where_the_camera_sees_it(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_picture(page)

    def grey(x_m: float, y_m: float) -> float:
        return float(
            page.evaluate(
                """([x, y]) => {
                  const { stage } = globalThis.clearway;
                  const k = stage.canvas.width / stage.width; // of another size
                  const at = [Math.round(k * stage.x(x)), Math.round(k * stage.y(y))];
                  return stage.canvas.getContext("2d").getImageData(...at, 1, 1).data[0];
                }""",
                [x_m, y_m],
            )
        )

    # the bucket of configs/arenas/laboratory.txt: C (0.42,1.16) 0.13
    for turn in range(8):
        c, s = math.cos(turn * math.tau / 8), math.sin(turn * math.tau / 8)
        assert grey(0.42 + 0.120 * c, 1.16 + 0.120 * s) < 90
        assert grey(0.42 + 0.140 * c, 1.16 + 0.140 * s) > 130


def test_a_clicked_goal_is_previewed_then_sent_and_the_robot_arrives(
    open_page: OpenPage, program: Live, keep: Keep
) -> None:
    page = open_page()
    wait_for_picture(page)
    x, y, _ = program.place()
    goal = max(HERE, THERE, key=lambda place: math.dist(place, (x, y)))
    click_at(page, *goal)
    preview = page.locator("#goal-preview")
    expect(preview).to_contain_text("clearance at least")
    assert program.state is not State.DRIVING, "nothing is sent before it is said so"
    length_m = float((preview.text_content() or "").split(" m")[0])
    assert length_m >= math.dist((x, y), goal) - 0.02
    expect(page.locator("#overlay .draft-path")).to_be_attached()
    keep(page, "preview")
    page.locator("#send").click()
    expect(page.locator("#mission-state")).to_have_text("Driving")
    until(program.is_moving)
    keep(page, "driving")
    expect(page.locator("#mission-state")).to_have_text("Arrived", timeout=180_000)
    assert math.dist(program.place()[:2], goal) < 0.03
    keep(page, "arrived")


def test_a_plan_that_gives_up_the_margin_says_so_before_and_while_it_is_driven(
    open_page: OpenPage, program: Live
) -> None:
    page = open_page()
    wait_for_picture(page)
    click_at(page, *WITHIN_THE_MARGIN)
    expect(page.locator("#goal-remarks")).to_contain_text(GIVEN_UP)
    send_to(page, *WITHIN_THE_MARGIN)
    expect(page.locator("#sentence")).to_contain_text(GIVEN_UP)
    expect(page.locator("#log")).to_contain_text(GIVEN_UP)
    until(program.drives)
    page.evaluate(  # a sentence that has no room for it
        """() => {
          const { connection } = clearway;
          const emit = connection.emit.bind(connection);
          connection.emit = (kind, message) => {
            if (kind === "state") message.mission.sentence = "driving slowly";
            emit(kind, message);
          };
        }"""
    )
    expect(page.locator("#sentence")).to_have_text("Driving slowly.")
    expect(page.locator("#reasons")).to_contain_text(GIVEN_UP)


def test_stop_stops_the_wheels_and_only_rearming_leaves_it(
    open_page: OpenPage, program: Live, keep: Keep
) -> None:
    page = open_page()
    wait_for_picture(page)
    set_off(program, page)
    page.locator("#stop").click()
    until(lambda: program.state is State.STOPPED)
    assert program.stands_within(1.5), "0.3 m/s and 0.5 m/s2 are 0.6 s of braking at most"
    expect(page.locator("#stopped")).to_be_visible()
    expect(page.locator("#stopped-text")).to_contain_text("its wheels are off")
    expect(page.locator("#mission-state")).to_have_text("Stopped")
    keep(page, "stopped")

    page.reload()
    wait_for_picture(page)
    expect(page.locator("#stopped")).to_be_visible()
    assert program.state is State.STOPPED, "loading the page again does not leave the stop"
    assert not program.is_moving()

    expect(page.locator("#rearm")).to_be_enabled()
    page.locator("#rearm").click()
    expect(page.locator("#stopped")).to_be_hidden()
    until(lambda: not program.daemon.robot.link.snapshot().estopped)
    assert not program.is_moving(), "re-arming moves nothing"


def test_pause_holds_and_resume_resumes(open_page: OpenPage, program: Live) -> None:
    page = open_page()
    wait_for_picture(page)
    set_off(program, page)
    page.locator("#pause").click()
    expect(page.locator("#mission-state")).to_have_text("Paused")
    assert program.stands_within(3.0)
    page.locator("#resume").click()
    expect(page.locator("#mission-state")).to_have_text("Driving")
    until(program.is_moving)


def test_the_robot_takes_no_order_until_it_is_cancelled_and_stop_works_all_the_time(
    bench: Bench, open_page: OpenPage, program: Live
) -> None:
    page = open_page()
    start_calibration(page)
    order = {"order": "go", "stations": [{"x_m": 1.8, "y_m": 0.5}]}
    refused = carry_out(order, program.daemon.people)
    assert refused == {"ok": False, "error": "the camera is being calibrated from the page"}
    page.locator("#stop").click()
    until(lambda: program.state is State.STOPPED)
    until(lambda: program.daemon.robot.link.snapshot().estopped)
    page.locator("#calibration-cancel").click()
    expect(page.locator("#calibration-said")).to_contain_text("Cancelled: nothing was written")
    expect(page.locator("#calibration-board")).to_be_visible()
    assert program.daemon.lent is None
    page.locator("#calibration-start").click()
    expect(page.locator("#calibration-said")).to_contain_text("re-arm the robot first")
