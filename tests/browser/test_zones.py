"""Zones on the page: shown to everybody, drawn, moved, named, deleted and undone by operators."""

from typing import Any, Final

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from navigation.config.zones import ZoneSection
from tests.browser.acting import click_at, drag, on_screen, wait_for_picture
from tests.browser.pages import HERE, THERE, Keep, OpenPage
from tests.browser.programs.served import ShownProgram, until

VIEWER = "a-token-for-looking"
ZONES: Final[tuple[dict[str, Any], ...]] = (
    {
        "name": "desk",
        "kind": "keep_out",
        "polygon": [[1.05, 0.15], [1.6, 0.15], [1.6, 0.5], [1.05, 0.5]],
    },
    {"name": "door", "kind": "slow", "circle": [2.0, 1.45, 0.25], "speed_m_s": 0.1},
    {"name": "aisle", "kind": "one_way", "line": [[0.3, 0.35], [0.8, 0.35]], "width_m": 0.2},
    {"name": "fast", "kind": "lane", "line": [[0.25, 1.6], [1.6, 1.6]], "width_m": 0.2},
    {"name": "crossing", "kind": "wait", "polygon": [[1.75, 0.7], [2.3, 0.7], [2.3, 1.1]]},
)
CORNERS = ((0.3, 0.6), (0.6, 0.6), (0.6, 0.9))


def have_zones(program: ShownProgram) -> None:
    for zone in ZONES:
        program.daemon.zones.put(ZoneSection.model_validate(zone))


def zone(program: ShownProgram, name: str) -> ZoneSection:
    """The zone of a name, which has to be there or to come."""
    until(lambda: name in names(program))
    return next(one for one in program.daemon.zones.sections if one.name == name)


def names(program: ShownProgram) -> list[str]:
    return [one.name for one in program.daemon.zones.sections]


def begin(page: Page) -> None:
    wait_for_picture(page)
    page.locator("#zones-open").click()
    page.locator("#zones-new").click()


def has_no_goal(page: Page, program: ShownProgram) -> bool:
    page.locator("#zones-close").click()
    expect(page.locator("#goal-stations")).to_be_hidden()
    return not any(order[0] in ("give", "resume") for order in program.daemon.orders)


@pytest.mark.parametrize("end", ["Enter", "double click", "first corner", "save"])
def test_a_polygon_is_drawn_by_clicks_and_no_click_sends_the_robot(
    end: str, open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    page = open_page()
    begin(page)
    for corner in CORNERS[:2]:
        click_at(page, *corner)
    if end == "double click":
        page.mouse.dblclick(*on_screen(page, *CORNERS[2]))
    else:
        click_at(page, *CORNERS[2])
    if end == "Enter":
        page.keyboard.press("Enter")
    elif end == "first corner":
        click_at(page, *CORNERS[0])
    keep(page, f"zone_{end.replace(' ', '_')}")
    assert page.locator("#stage").get_attribute("data-zoom") == "1.00"
    if end in ("Enter", "double click", "first corner"):
        click_at(page, 1.4, 1.4)  # it is closed: no more corners
    page.locator("#zone-save").click()
    made = zone(program, "keep-out-1")
    assert made.kind == "keep_out"
    assert made.polygon is not None
    for found, drawn in zip(made.polygon, CORNERS, strict=True):
        assert found == pytest.approx(drawn, abs=0.006), "to a pixel"
    expect(page.locator("#zones-note")).to_have_text("Keep-out-1 is in force.")
    expect(page.locator("[data-layer=zones] .zone-keep-out")).to_have_count(1)
    assert has_no_goal(page, program)
    assert program.daemon.orders == [("put_zone", "keep-out-1")]


def test_a_circle_is_drawn_from_its_centre_and_a_slow_zone_needs_a_speed(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    begin(page)
    page.locator("#zone-kind").select_option("slow")
    page.locator("#zone-shape").select_option("circle")
    expect(page.locator("#zone-name")).to_have_value("slow-1")
    drag(page, (1.0, 0.9), (1.3, 0.9))
    page.locator("#zone-save").click(force=True)
    expect(page.locator("#zone-error")).to_contain_text("speed must be a number > 0")
    page.locator("#zone-speed").fill("0,12")
    page.locator("#zone-save").click()
    made = zone(program, "slow-1")
    assert made.circle == pytest.approx((1.0, 0.9, 0.3), abs=0.01)
    assert made.speed_m_s == 0.12
    expect(page.locator("[data-layer=zone-names]")).to_contain_text("max 0.12 m/s")


def test_a_lane_is_a_band_along_clicks_with_a_width_and_a_cost(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    begin(page)
    page.locator("#zone-kind").select_option("lane")
    expect(page.locator("#zone-shape")).to_have_value("line")
    for corner in CORNERS:
        click_at(page, *corner)
    page.keyboard.press("Enter")
    page.locator("#zone-size").fill("0.15")
    page.locator("#zone-cost").fill("0.2")
    page.locator("#zone-name").fill("to-the-door")
    page.keyboard.press("Enter")
    made = zone(program, "to-the-door")
    assert (made.kind, made.width_m, made.cost) == ("lane", 0.15, 0.2)
    assert made.line is not None
    assert len(made.line) == 3


def test_a_zone_is_made_with_the_keyboard_alone(open_page: OpenPage, program: ShownProgram) -> None:
    page = open_page()
    wait_for_picture(page)
    page.keyboard.press("z")
    expect(page.locator("#zones-new")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.locator("#zone-kind")).to_be_focused()
    page.keyboard.type("No")
    for _ in range(4):
        page.keyboard.press("Tab")
    page.keyboard.type("1.0, 0.2\n1.4 0.2\n1.4;0.6")
    expect(page.locator("[data-layer=zone-draft] .zone.zone-wait")).to_be_attached()
    page.keyboard.press("Tab")
    expect(page.locator("#zone-save")).to_be_focused()
    page.keyboard.press("Enter")
    made = zone(program, "wait-1")
    assert made.kind == "wait"
    assert made.polygon == ((1.0, 0.2), (1.4, 0.2), (1.4, 0.6))
    expect(page.locator("#zones-note")).to_have_text("Wait-1 is in force.")
    page.keyboard.press("Escape")
    expect(page.locator("#zones")).to_be_hidden()
    assert not program.is_stopped(), "a space between numbers stops no robot that is at rest"


def test_a_change_is_taken_back_and_escape_leaves_without_a_zone(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    begin(page)
    places = page.locator("#zone-places")
    for corner in CORNERS:
        click_at(page, *corner)
    assert len(places.input_value().splitlines()) == 3
    page.keyboard.press("Backspace")
    assert len(places.input_value().splitlines()) == 2
    page.keyboard.press("Control+z")
    assert len(places.input_value().splitlines()) == 1
    page.locator("#zone-back").click()
    expect(places).to_have_value("")
    click_at(page, *CORNERS[0])
    page.keyboard.press("Escape")
    expect(page.locator("#zone-form")).to_be_hidden()
    expect(page.locator("#zones")).to_be_visible()
    expect(page.locator("[data-layer=zone-draft] *")).to_have_count(0)
    page.keyboard.press("Escape")
    expect(page.locator("#zones")).to_be_hidden()
    assert names(program) == []


def test_a_zone_is_edited_moved_and_renamed_and_one_undo_takes_each_back(
    open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    have_zones(program)
    page = open_page()
    wait_for_picture(page)
    page.locator("#zones-open").click()
    page.get_by_label("Edit desk").click()
    drag(page, (1.6, 0.5), (1.7, 0.6))
    drag(page, (1.3, 0.3), (1.3, 0.4))
    keep(page, "zone_moved")
    page.locator("#zone-name").fill("table")
    page.locator("#zone-save").click()
    moved = zone(program, "table").polygon
    assert moved is not None
    expected = ((1.05, 0.25), (1.6, 0.25), (1.7, 0.7), (1.05, 0.6))
    for found, place in zip(moved, expected, strict=True):
        assert found == pytest.approx(place, abs=0.01)
    expect(page.get_by_label("Edit table")).to_be_visible()
    expect(page.get_by_label("Edit desk")).to_have_count(0)
    page.locator("#zones-undo").click()
    expect(page.get_by_label("Edit desk")).to_be_visible()
    expect(page.get_by_label("Edit table")).to_have_count(0)
    assert zone(program, "desk").polygon == ZoneSection.model_validate(ZONES[0]).polygon
    page.get_by_label("Delete door").click()
    expect(page.locator("#zones-note")).to_have_text("Door is removed.")
    expect(page.locator("#zones-list li")).to_have_count(4)
    page.keyboard.press("Control+z")
    expect(page.locator("#zones-list li")).to_have_count(5)
    assert has_no_goal(page, program)


def test_a_zone_is_chosen_for_a_change_by_a_click_in_it(
    open_page: OpenPage, program: ShownProgram
) -> None:
    have_zones(program)
    page = open_page()
    wait_for_picture(page)
    page.locator("#zones-open").click()
    click_at(page, 0.6, 0.3)
    expect(page.locator("#zone-name")).to_have_value("aisle")
    expect(page.locator("[data-layer=zones] [data-name=aisle]")).to_have_count(0)
    page.keyboard.press("Escape")
    expect(page.locator("[data-layer=zones] [data-name=aisle]")).to_have_count(1)


def test_what_the_program_refuses_is_said_in_the_form(
    open_page: OpenPage, program: ShownProgram
) -> None:
    have_zones(program)
    page = open_page()
    begin(page)
    page.locator("#zone-places").fill("0.3, 0.6\n0.6, 0.9\n0.6, 0.6\n0.3, 0.9")
    page.locator("#zone-save").click()
    expect(page.locator("#zone-error")).to_contain_text("cross")
    expect(page.locator("#zone-error")).to_be_in_viewport()
    page.locator("#zone-places").fill("0.3, 0.6\n0.6, north")
    page.locator("#zone-save").click(force=True)
    expect(page.locator("#zone-error")).to_have_text("Each line must be a place: x, y in metres.")
    page.locator("#zone-places").fill("0.3, 0.6\n0.6, 0.6\n0.6, 0.9")
    page.locator("#zone-name").fill("desk")
    page.locator("#zone-save").click(force=True)
    expect(page.locator("#zone-error")).to_have_text("There is a zone 'desk' already.")
    assert len(names(program)) == len(ZONES)


def test_a_goal_that_was_set_before_is_not_sent_by_enter_among_zones(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    wait_for_picture(page)
    click_at(page, *THERE)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    begin(page)
    for corner in CORNERS:
        click_at(page, *corner)
    page.keyboard.press("Enter")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Enter")
    zone(program, "keep-out-1")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Enter")
    page.locator("#zones-close").click()
    expect(page.locator("#goal-stations li")).to_have_count(1)
    assert [order[0] for order in program.daemon.orders] == ["put_zone"]
    assert not program.drives()


def test_the_space_bar_stops_while_a_zone_is_drawn(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    begin(page)
    click_at(page, *CORNERS[0])
    page.keyboard.press("Space")
    until(program.is_stopped)
    expect(page.locator("#zone-places")).to_have_value("0.3, 0.6")


def test_a_viewer_sees_the_zones_and_can_change_none(
    open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    have_zones(program)
    config = program.daemon.config
    section = config.dashboard.model_copy(update={"viewer_token": VIEWER})
    program.daemon.config = config.model_copy(update={"dashboard": section})
    program.bring_back(token="a-token-of-some-length")
    page = open_page(f"{program.url}#token={VIEWER}")
    wait_for_picture(page)
    expect(page.locator("[data-layer=zones] .zone")).to_have_count(5)
    page.locator("#zones-open").click()
    expect(page.locator("#zones-list li")).to_have_count(5)
    expect(
        page.locator("#zones-list button, #zones-new, #zones-undo").locator("visible=true")
    ).to_have_count(0)
    click_at(page, 1.3, 0.3)
    expect(page.locator("#zones-note")).to_have_text("Desk: keep out.")
    expect(page.locator("[data-name=desk].is-marked")).to_have_count(1)
    page.keyboard.press("Control+z")
    keep(page, "zones_of_a_viewer")
    assert program.daemon.orders == []
    assert program.daemon.zones.revision == len(ZONES)


def test_zones_are_a_layer_that_is_on_for_people_who_have_come_before(
    open_page: OpenPage, program: ShownProgram
) -> None:
    have_zones(program)
    page = open_page()
    wait_for_picture(page)
    page.evaluate("localStorage.setItem('clearway.layers', JSON.stringify({track: false}))")
    page.reload()
    wait_for_picture(page)
    shapes = page.locator("[data-layer=zones]")
    expect(shapes).to_be_visible()
    page.locator("#layers-open").click()
    expect(page.locator("#layer-track")).not_to_be_checked()
    page.locator("#layer-zones").uncheck()
    expect(shapes).to_be_hidden()
    page.reload()
    wait_for_picture(page)
    expect(shapes).to_be_hidden()
    page.locator("#zones-open").click()
    expect(shapes).to_be_visible()


def test_a_zone_that_a_sentence_names_is_drawn_stronger(
    open_page: OpenPage, program: ShownProgram
) -> None:
    have_zones(program)
    page = open_page()
    wait_for_picture(page)
    expect(page.locator("[data-layer=zones] .zone")).to_have_count(5)
    expect(page.locator(".zone.is-marked")).to_have_count(0)
    program.daemon.show(sentence="the only path leads through keep-out zone 'desk'")
    expect(page.locator("[data-name=desk].is-marked")).to_have_count(1)
    program.daemon.show(sentence="waiting")
    expect(page.locator(".zone.is-marked")).to_have_count(0)


def test_on_a_phone_a_zone_is_looked_at_and_deleted(
    open_page: OpenPage, program: ShownProgram, keep: Keep
) -> None:
    have_zones(program)
    page = open_page(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    wait_for_picture(page)
    page.locator("#zones-open").tap()
    keep(page, "zones_on_a_phone")
    page.get_by_label("Delete crossing").tap()
    expect(page.locator("#zones-list li")).to_have_count(4)
    assert "crossing" not in names(program)


def test_an_arena_is_clicked_for_goals_again_after_the_zones_are_closed(
    open_page: OpenPage, program: ShownProgram
) -> None:
    page = open_page()
    begin(page)
    click_at(page, *HERE)
    page.locator("#zones-close").click()
    click_at(page, *THERE)
    expect(page.locator("#goal-preview")).to_contain_text("clearance at least")
    expect(page.locator("#goal-stations li")).to_have_count(1)
