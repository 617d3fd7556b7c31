"""What the browser's tests are given, and a drive that has begun."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page

from navigation.mission.mission import State
from tests.browser.acting import send_to
from tests.browser.live import Live
from tests.support.waiting import wait_until

OpenPage = Callable[..., Page]
Keep = Callable[[Page, str], Path]
HERE, THERE = (0.25, 0.75), (0.30, 1.50)
"""Two places not far from where the robot starts."""


def drive(live: Live, page: Page) -> None:
    """Send the robot to whichever of two places is farther, and wait until it moves."""
    x, y, _ = live.place()
    goal = max(HERE, THERE, key=lambda place: math.dist(place, (x, y)))
    send_to(page, *goal)
    assert wait_until(lambda: live.state is State.DRIVING and live.is_moving(), 20.0)
