"""Chromium, a running program, and pages that must not have errors."""

import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.browser.live import Live, live_config

CHROMIUM = os.environ.get("CLEARWAY_CHROMIUM", "/usr/bin/chromium")
ARGUMENTS = ["--no-sandbox", "--disable-dev-shm-usage", "--headless"]
PICTURES = Path(__file__).parents[2] / "build" / "browser"
"""Where the screenshots go."""

playwright_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Browser, ConsoleMessage, Page, expect, sync_playwright  # noqa: E402

PATIENCE_MS = 45_000
"""Nothing may depend on the machine's being fast."""
expect.set_options(timeout=PATIENCE_MS)


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    if not Path(CHROMIUM).exists():
        pytest.skip(f"{CHROMIUM} is missing: apt-get install --no-install-recommends chromium")
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=CHROMIUM,
            args=ARGUMENTS,
            ignore_default_args=["--hide-scrollbars"],  # people have them, and they take room
        )
        yield chromium
        chromium.close()


@pytest.fixture(scope="package")
def program(browser: Browser) -> Iterator[Live]:
    """One program for all tests: each leaves it without stop and mission (`live`)."""
    with Live(live_config()) as live:
        yield live


@pytest.fixture
def live(program: Live) -> Iterator[Live]:
    yield program
    program.calm_down()


@pytest.fixture
def open_page(browser: Browser, live: Live) -> Iterator[Callable[..., Page]]:
    """Opens the page in a browser of its own; at the end no page may have had an error."""
    contexts = []
    errors: list[str] = []

    def open_page(address: str | None = None, *, allowed: str = "(?!)", **options: object) -> Page:
        settings = {"viewport": {"width": 1360, "height": 860}, **options}
        context = browser.new_context(**settings)  # type: ignore[arg-type]
        contexts.append(context)
        page = context.new_page()

        def note(message: ConsoleMessage) -> None:
            if message.type == "error" and not re.search(allowed, message.text):
                errors.append(message.text)

        page.on("console", note)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.set_default_timeout(PATIENCE_MS)
        page.goto(address or live.url)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert errors == []


@pytest.fixture
def keep(request: pytest.FixtureRequest) -> Callable[[Page, str], Path]:
    """Keeps a screenshot among the build's artefacts."""

    def keep(page: Page, name: str) -> Path:
        PICTURES.mkdir(parents=True, exist_ok=True)
        file = PICTURES / f"{name}.png"
        page.screenshot(path=file)
        return file

    return keep
