"""What a person does on the page, in the arena's metres."""

from typing import Any

from playwright.sync_api import Page, expect


def wait_for_picture(page: Page, count: int = 3) -> None:
    """Until so many pictures were drawn, and the diagram is there."""
    page.wait_for_function("n => globalThis.clearway?.picture.count >= n", arg=count)
    expect(page.locator("[data-layer=roadmap] path").first).to_be_attached()
    expect(page.locator("[data-layer=robots] .robot")).to_be_attached()


def on_screen(page: Page, x_m: float, y_m: float) -> tuple[float, float]:
    """Where a place of the arena is on the screen; whoever has scrolled scrolls back to it."""
    page.evaluate("scrollTo(0, 0)")
    box: Any = page.evaluate("([x, y]) => globalThis.clearway.stage.onScreen(x, y)", [x_m, y_m])
    return float(box[0]), float(box[1])


def click_at(page: Page, x_m: float, y_m: float, *, shift: bool = False) -> None:
    """Click at a place of the arena."""
    if shift:
        page.keyboard.down("Shift")
    page.mouse.click(*on_screen(page, x_m, y_m))
    if shift:
        page.keyboard.up("Shift")


def drag(page: Page, start_m: tuple[float, float], end_m: tuple[float, float]) -> None:
    """Press at one place, let go at another."""
    page.mouse.move(*on_screen(page, *start_m))
    page.mouse.down()
    page.mouse.move(*on_screen(page, *end_m), steps=4)
    page.mouse.up()


def send_to(page: Page, x_m: float, y_m: float) -> None:
    """Set a goal, see its preview, send it."""
    click_at(page, x_m, y_m)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    page.locator("#send").click()
    expect(page.locator("#goal-hint")).to_be_visible()


def start_calibration(page: Page) -> None:
    """Calibrate with the board of the tests."""
    wait_for_picture(page)
    page.locator("#calibration-open").click()
    page.locator("#board-squares").fill("8x6")
    page.locator("#board-square_mm").fill("100")
    page.locator("#board-marker_mm").fill("75")
    page.locator("#board-dictionary").fill("DICT_5X5_100")
    page.locator("#calibration-start").click()
    expect(page.locator("#calibration-view")).to_be_visible()


def lose_connection(page: Page) -> None:
    """Lose the connection to a program that continues; the page does not connect again."""
    page.evaluate(
        """() => {
          const { connection } = clearway;
          connection.open = () => {};
          connection.useToken(connection.token ?? "");
        }"""
    )
    expect(page.locator("#lost")).to_be_visible()


def regain_connection(page: Page) -> None:
    """Connect again, until all that the program sends at first has arrived."""
    page.evaluate(
        """() => new Promise((resolve) => {
          const { connection } = clearway;
          connection.on("hello", () => connection.on("samples", resolve));
          delete connection.open;
          dispatchEvent(new Event("online"));
        })"""
    )
    expect(page.locator("#lost")).to_be_hidden()
