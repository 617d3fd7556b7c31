"""Chromium, a program that only shows, and pages that must not have errors.

A module whose pages are of another program has a fixture ``program`` of its own.
"""

import asyncio
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol

import pytest

from planner.roadmap.roadmap import Roadmap
from tests.browser.programs.served import PATIENCE_S, ShownProgram
from tests.support.runs.shown import FakeDaemon, laboratory

CHROMIUM = os.environ.get("CLEARWAY_CHROMIUM", "/usr/bin/chromium")
UNUSED = [
    # the window of each context would load a page for the list below its address bar
    "WebUIOmniboxPopup", "WebUIOmniboxAimPopup", "WebUIOmniboxFullPopup", "PreloadTopChromeWebUI",
    # what Playwright turns off by the same option, of which only the last one counts
    "AvoidUnnecessaryBeforeUnloadCheckSync", "DestroyProfileOnBrowserClose", "HttpsUpgrades",
    "HttpsFirstBalancedModeAutoEnable", "LensOverlay", "MediaRouter", "PaintHolding",
    "ThirdPartyStoragePartitioning", "AvoidCorsURLLoaderRestartOnRedirect", "OptimizationHints",
    "NetworkTimeServiceQuerying", "AimEnabled", "PreconnectToSearch",
]  # fmt: skip
ARGUMENTS = [
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--headless",
    f"--disable-features={','.join(UNUSED)}",
]
PICTURES = Path(__file__).parents[2] / "build" / "browser"
"""Where the screenshots go."""
DESKTOP = {"width": 1360, "height": 860}
KEEPS = bool(os.environ.get("CLEARWAY_SCREENSHOTS"))
"""For people to look at, as in `make browser`: no test needs them."""

playwright_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Browser, ConsoleMessage, Page, expect, sync_playwright  # noqa: E402

PATIENCE_MS = 1000.0 * PATIENCE_S
expect.set_options(timeout=PATIENCE_MS)


@pytest.fixture(scope="session")
def chromium() -> Iterator[tuple[Browser, asyncio.AbstractEventLoop]]:
    """Chromium, one for each worker, and the event loop that Playwright runs in this thread."""
    if not Path(CHROMIUM).exists():
        pytest.skip(f"{CHROMIUM} is missing: apt-get install --no-install-recommends chromium")
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=CHROMIUM,
            args=ARGUMENTS,
            ignore_default_args=["--hide-scrollbars"],  # people have them, and they take room
        )
        loop = asyncio.get_running_loop()
        # Playwright leaves its loop set in this thread; asyncio has no public name to unset it
        asyncio._set_running_loop(None)
        yield chromium, loop
        asyncio._set_running_loop(loop)
        chromium.close()


@pytest.fixture(scope="module")
def browser(chromium: tuple[Browser, asyncio.AbstractEventLoop]) -> Iterator[Browser]:
    """Chromium while a file is tested. Its event loop stands still for the files that a worker
    gets next, which may want one of their own in this thread."""
    browser, loop = chromium
    asyncio._set_running_loop(loop)
    yield browser
    asyncio._set_running_loop(None)


@pytest.fixture(scope="session")
def roadmap() -> Roadmap:
    """The roadmap of the shipped arena."""
    return laboratory()


@pytest.fixture
def program(roadmap: Roadmap) -> Iterator[ShownProgram]:
    """A program that only shows, as good as new for each test."""
    with ShownProgram(FakeDaemon(roadmap=roadmap)) as program:
        yield program


class HasUrl(Protocol):
    """A program with a page."""

    @property
    def url(self) -> str | None:
        """Its address."""
        ...


@pytest.fixture
def open_page(browser: Browser, program: HasUrl) -> Iterator[Callable[..., Page]]:
    """Opens the page in a browser of its own; at the end no page may have had an error."""
    contexts = []
    errors: list[str] = []

    def open_page(address: str | None = None, *, allowed: str = "(?!)", **options: object) -> Page:
        # a dot that beats makes a new frame sixty times a second
        settings = {"viewport": DESKTOP, "reduced_motion": "reduce", **options}
        context = browser.new_context(**settings)  # type: ignore[arg-type]
        contexts.append(context)
        page = context.new_page()

        def note(message: ConsoleMessage) -> None:
            if message.type == "error" and not re.search(allowed, message.text):
                errors.append(message.text)

        page.on("console", note)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.set_default_timeout(PATIENCE_MS)
        page.goto(address or program.url or "")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert errors == []


@pytest.fixture
def open_fleet(open_page: Callable[..., Page]) -> Callable[..., Page]:
    """Opens the page of six robots, and waits until it shows them."""

    def open_fleet(**options: object) -> Page:
        page = open_page(**options)
        page.wait_for_function("n => globalThis.clearway?.picture.count >= n", arg=1)
        expect(page.locator("[data-layer=fleet-bodies] .own-robot")).to_have_count(6)
        return page

    return open_fleet


@pytest.fixture
def keep() -> Callable[[Page, str], None]:
    """Keeps a screenshot among the build's artefacts, where they are asked for."""

    def keep(page: Page, name: str) -> None:
        if KEEPS:
            PICTURES.mkdir(parents=True, exist_ok=True)
            page.screenshot(path=PICTURES / f"{name}.png")

    return keep
