"""The page asks for pictures in the size that it shows, and for none while it is hidden."""

from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page

from navigation.dashboard.attention import Attention
from planner.roadmap.roadmap import Roadmap
from tests.browser.acting import wait_for_picture
from tests.browser.pages import OpenPage
from tests.browser.programs.served import ShownProgram, until
from tests.support.runs.shown import FakeDaemon, shown_config

MOST_PX = 960


@pytest.fixture
def program(roadmap: Roadmap) -> Iterator[ShownProgram]:
    """With pictures as large as by default."""
    config = shown_config(picture_width_px=MOST_PX)
    with ShownProgram(FakeDaemon(config, roadmap=roadmap)) as program:
        yield program


def the_viewer(program: ShownProgram) -> Attention:
    """The page to its program: a page that has connected again is another one."""
    until(lambda: len(program.hub.viewers) == 1)
    (viewer,) = program.hub.viewers
    return viewer


def shown_px(page: Page) -> int:
    """How wide the whole picture is on the screen, in its pixels."""
    return int(
        page.evaluate(
            "document.getElementById('picture').getBoundingClientRect().width * devicePixelRatio"
        )
    )


def drawn_px(page: Page, canvas: str = "picture") -> int:
    return int(page.evaluate("id => document.getElementById(id).width", canvas))


@pytest.mark.parametrize(
    ("width", "height", "scale"), [(1360, 860, 1.0), (900, 560, 1.0), (390, 844, 2.0)]
)
def test_a_page_gets_what_it_shows_and_follows_window_and_zoom(
    width: int, height: int, scale: float, open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page(viewport={"width": width, "height": height}, device_scale_factor=scale)
    wait_for_picture(page)
    shown = shown_px(page)
    assert shown > 100
    until(lambda: 0 <= the_viewer(program).width_px - min(shown, MOST_PX) <= MOST_PX / 8)
    until(lambda: drawn_px(page) == the_viewer(program).width_px)
    before_px = the_viewer(program).width_px
    for _ in range(3):
        page.locator("#zoom-in").click()
    until(lambda: the_viewer(program).width_px == MOST_PX)
    until(lambda: drawn_px(page) == MOST_PX)
    page.locator("#zoom-fit").click()
    until(lambda: the_viewer(program).width_px == before_px)
    page.set_viewport_size({"width": 400, "height": 500})
    until(lambda: the_viewer(program).width_px < before_px or before_px <= 720)


def hide(page: Page, hidden: bool) -> None:
    """As a browser does whose window is covered, or its tab left."""
    page.evaluate(
        """(hidden) => {
          Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
          document.dispatchEvent(new Event("visibilitychange"));
        }""",
        hidden,
    )


def test_a_hidden_page_gets_none_and_a_shown_one_gets_them_again(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    wait_for_picture(page)
    hub = program.hub
    hide(page, True)
    until(lambda: not the_viewer(program).is_watching)
    until(lambda: not hub.pictures)
    sent, state = hub.pictures_sent, hub.state_number
    until(lambda: hub.state_number > state + 10)
    assert hub.pictures_sent == sent
    page.set_viewport_size({"width": 900, "height": 600})  # what it says then shows no picture
    page.locator("#zoom-in").click()
    state = hub.state_number
    until(lambda: hub.state_number > state + 10)
    assert hub.pictures_sent == sent
    hide(page, False)
    count = page.evaluate("clearway.picture.count")
    wait_for_picture(page, count + 2)


def test_the_camera_s_picture_comes_in_the_page_s_size_with_what_was_found_in_place(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page(viewport={"width": 390, "height": 844})
    wait_for_picture(page)
    page.locator("#stage").focus()
    page.keyboard.press("9")
    until(lambda: the_viewer(program).kind == "camera")
    until(lambda: drawn_px(page, "camera") == the_viewer(program).width_px)
    assert the_viewer(program).width_px < 480, (
        "the width of the camera's picture, in whose pixels the rim is"
    )
    r, _, b = page.evaluate(
        """() => {
          const canvas = document.getElementById("camera");
          const at = [canvas.width - 1, canvas.height >> 1, 1, 1];
          return [...canvas.getContext("2d").getImageData(...at).data].slice(0, 3);
        }"""
    )
    assert abs(r - b) > 20, "the arena's rim, in colour, at the edge of a grey picture"
