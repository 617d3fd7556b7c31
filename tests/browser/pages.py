"""What the browser's tests are given, and a drive that has begun."""

from collections.abc import Callable

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from tests.browser.acting import send_to
from tests.browser.programs.served import ShownProgram, until

OpenPage = Callable[..., Page]
Keep = Callable[[Page, str], None]
HERE, THERE = (0.25, 0.75), (0.30, 1.50)
"""Two places not far from where the robot starts."""
AWAY = "ERR_(CONNECTION_(REFUSED|RESET|CLOSED)|SOCKET_NOT_CONNECTED)"
"""The browser's words for a program that goes away, before its request or in the middle of it."""


def drive(program: ShownProgram, page: Page) -> None:
    """Send the robot off, and wait until the page knows it."""
    send_to(page, *THERE)
    until(program.drives)
    expect(page.locator("#mission-state")).to_have_text("Driving")
