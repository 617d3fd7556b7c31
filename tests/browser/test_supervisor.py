"""A supervisor's page and a student's: who is in control, and who has taken it from whom."""

from collections.abc import Iterator

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from planner.roadmap.roadmap import Roadmap
from tests.browser.acting import click_at, wait_for_picture
from tests.browser.pages import HERE, Keep, OpenPage, drive
from tests.browser.programs.served import ShownProgram, until
from tests.support.runs.shown import FakeDaemon, shown_config

TOKEN, SUPERVISOR = "a-token-of-some-length", "a-token-for-the-teacher"


@pytest.fixture
def program(roadmap: Roadmap) -> Iterator[ShownProgram]:
    """With a token for each of both."""
    config = shown_config(token=TOKEN, supervisor_token=SUPERVISOR)
    with ShownProgram(FakeDaemon(config, roadmap=roadmap)) as program:
        program.bring_back(token=TOKEN)
        yield program


def opened(open_page: OpenPage, program: ShownProgram, token: str, name: str) -> Page:
    page = open_page(f"{program.url}#token={token}")
    wait_for_picture(page)
    page.locator("#name").fill(name)
    page.locator("#name").press("Tab")
    return page


def test_a_supervisor_takes_control_by_the_button_and_not_by_a_click_in_the_arena(
    open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    student = opened(open_page, program, TOKEN, "Tom")
    teacher = opened(open_page, program, SUPERVISOR, "Ms Lee")
    drive(program, student)
    expect(student.locator("#seat-text")).to_have_text("You are in control")
    expect(teacher.locator("#seat-text")).to_have_text("Tom is in control")
    click_at(teacher, *HERE)
    expect(teacher.locator("#refusal")).to_contain_text('press "Take control" to take it from them')
    expect(student.locator("#seat-text")).to_have_text("You are in control")
    teacher.locator("#seat").click()
    sentence = "The supervisor Ms Lee has taken control from Tom."
    expect(teacher.locator("#refusal-text")).to_have_text(sentence)
    expect(student.locator("#refusal-text")).to_have_text(sentence)
    expect(teacher.locator("#seat-text")).to_have_text("You are in control")
    expect(student.locator("#seat-text")).to_have_text("Ms Lee is in control")
    expect(student.locator("#seat")).to_be_hidden()
    assert program.drives(), "the mission goes on"
    keep(student, "control_was_taken")
    keep(teacher, "control_taken")
    student.keyboard.press("Space")
    until(program.is_stopped)
