"""Pictures in the size that a page shows: few sizes for all, none for a page that is hidden."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.dashboard.attention import Attention
from navigation.dashboard.hub import Hub
from navigation.dashboard.messages.picture import SIZES, TopView, encode_widths, width_for
from planner.scene import Bounds
from tests.navigation.dashboard.site import Page, Site
from tests.support.runs.shown import FakeDaemon, frame, laboratory, shown_config
from tests.support.waiting import wait_until
from vision.camera.camera import Frame

MOST_PX = 160
"""`picture_width_px` of these sites."""


class Encoder:
    """Counts what a hub encodes: a set of widths for each round."""

    def __init__(self, hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
        self.rounds: list[set[int]] = []
        real = hub.view.jpegs

        def jpegs(shown: Frame, widths_px: Iterable[int]) -> dict[int, Any]:
            self.rounds.append(set(widths_px))
            return real(shown, widths_px)

        monkeypatch.setattr(hub.view, "jpegs", jpegs)


@pytest.fixture
def encoder(site: Site, monkeypatch: pytest.MonkeyPatch) -> Encoder:
    assert site.dashboard.hub is not None
    return Encoder(site.dashboard.hub, monkeypatch)


def watch(page: Page, **message: object) -> None:
    """Say what is shown; the program has read it when this returns."""
    page.send(type="watch", **message)
    page.send(type="ping", id=1)
    page.hear("pong")


def size_of(message: dict[str, Any]) -> tuple[int, int]:
    """Width and height of a message's picture."""
    height, width = cv2.imdecode(message["arrays"]["jpeg"], cv2.IMREAD_UNCHANGED).shape[:2]
    return width, height


# The sizes.


@given(shown_px=st.integers(1, 10**30), most_px=st.integers(160, 4096))
def test_a_picture_fills_what_is_shown_and_is_at_most_an_eighth_wider(
    shown_px: int, most_px: int
) -> None:
    width = width_for(shown_px, most_px)
    assert width >= min(shown_px, most_px)
    assert 0 <= width - min(shown_px, most_px) <= most_px / SIZES + 1
    assert width == width_for(width, most_px)


@given(most_px=st.integers(160, 4096))
def test_there_are_eight_sizes_whatever_pages_say(most_px: int) -> None:
    widths = {width_for(shown, most_px) for shown in range(1, most_px + 2)}
    assert len(widths) == SIZES == 8
    assert max(widths) == most_px


@pytest.mark.parametrize("colours", [1, 3])
def test_a_small_picture_shows_the_whole_in_place(colours: int) -> None:
    rows, columns = np.mgrid[0:240, 0:320]
    grey = (128 + 60 * np.sin(columns / 25.0) * np.cos(rows / 19.0)).astype(np.uint8)
    image = grey if colours == 1 else np.dstack([grey] * 3)
    made = encode_widths(image, (40, 200, 320, 640), 90)
    assert {w: cv2.imdecode(jpeg, 0).shape for w, jpeg in made.items()} == {
        40: (30, 40), 200: (150, 200), 320: (240, 320), 640: (240, 320),
    }  # fmt: skip
    for width, jpeg in made.items():
        shown = cv2.resize(cv2.imdecode(jpeg, 0), (320, 240), interpolation=cv2.INTER_CUBIC)
        error = np.abs(shown.astype(float) - grey)[20:-20, 20:-20]
        assert error.mean() < (4.0 if width == 40 else 1.5)


def test_a_wide_and_flat_picture_has_a_row_at_least() -> None:
    (jpeg,) = encode_widths(np.zeros((2, 800), np.uint8), (100,), 60).values()
    assert cv2.imdecode(jpeg, 0).shape == (1, 100)


def test_a_view_has_the_window_s_shape_in_each_size() -> None:
    daemon = FakeDaemon()
    view = TopView(daemon.calibration, Bounds(*daemon.config.arena.bounds_m), MOST_PX, 60)
    for width, jpeg in view.jpegs(frame(1), (40, 160)).items():
        shape = cv2.imdecode(jpeg, 0).shape
        assert shape[1] == width
        assert shape[0] == pytest.approx(width * view.window.height / view.window.width, abs=1.0)


# Pages.


@pytest.mark.parametrize(
    ("said", "width"), [(1, 20), (20, 20), (21, 40), (81, 100), (160, 160), (161, 160)]
)
def test_a_page_gets_the_size_that_fills_it(said: int, width: int, quiet_site: Site) -> None:
    with quiet_site.live() as page:
        page.send(type="watch", on=True, width_px=said)
        assert size_of(page.hear("picture"))[0] == width


def test_a_page_that_says_no_size_gets_the_largest(quiet_site: Site) -> None:
    with quiet_site.live() as page:
        page.send(type="watch", on=True)
        assert size_of(page.hear("picture"))[0] == MOST_PX
    with quiet_site.live() as page:
        page.send(type="watch", on=True, camera=True, width_px=50)
        message = page.hear("camera")
        assert (size_of(message), message["size_px"]) == ((60, 45), [160, 120])


@pytest.mark.parametrize("huge", [4097, 2**31, 2**53, 10**300])
def test_a_huge_page_gets_the_largest(huge: int, quiet_site: Site) -> None:
    with quiet_site.live() as page:
        page.send(type="watch", on=True, width_px=huge)
        assert size_of(page.hear("picture"))[0] == MOST_PX


@pytest.mark.parametrize(
    "odd", [0, -1, -(10**300), 80.5, 1e999, "80", "", True, False, None, [80], {"px": 80}]
)
def test_an_odd_size_is_refused_in_one_sentence_and_changes_nothing(
    odd: object, quiet_site: Site
) -> None:
    before = quiet_site.refused("malformed")
    with quiet_site.live() as page:
        watch(page, on=True, width_px=50)
        page.send(type="watch", on=True, camera=True, heat=True, width_px=odd)
        sentence = page.hear("error")["error"]
        assert sentence.startswith("width_px: must be a whole number >= 1, not ")
        assert quiet_site.refused("malformed") == before + 1
        quiet_site.daemon.show(frame=frame(2))
        assert size_of(page.hear("picture"))[0] == 60


def test_pages_of_one_size_cost_one_picture_and_of_another_one_more(
    site: Site, encoder: Encoder
) -> None:
    hub = site.dashboard.hub
    assert hub is not None
    with site.live() as first, site.live() as second, site.live() as third:
        for page, said in ((first, 70), (second, 80), (third, 160)):
            watch(page, on=True, width_px=said)
            page.hear("picture")
        del encoder.rounds[:]
        site.daemon.cycle()
        numbers = [page.hear("picture")["number"] for page in (first, second, third)]
        assert wait_until(lambda: len(hub.pictures) == 2)
    assert sorted(width for made in encoder.rounds for width in made) == [80, 160], numbers


def test_a_page_that_changes_its_size_all_the_time_makes_no_further_ones(
    site: Site, encoder: Encoder
) -> None:
    hub = site.dashboard.hub
    assert hub is not None
    with site.live() as page, site.live() as other:
        other.send(type="watch", on=True, width_px=MOST_PX)
        other.hear("picture")
        for number in range(200):
            page.send(type="watch", on=True, camera=number % 2 == 0, width_px=1 + number)
            page.send(type="ack")
            if number % 20 == 0:
                site.daemon.cycle()
                other.send(type="ack")
                other.hear("picture")
        watch(page, on=False)
        assert {width for made in encoder.rounds for width in made} <= set(range(20, 161, 20))
        site.daemon.cycle()
        assert wait_until(lambda: hub.pictures.keys() == {("picture", MOST_PX)})


def test_a_hidden_page_gets_no_picture_and_none_is_made_for_it(
    site: Site, encoder: Encoder
) -> None:
    hub = site.dashboard.hub
    assert hub is not None
    with site.live() as page:
        for kind in ("picture", "camera"):
            watch(page, on=True, camera=kind == "camera", width_px=100)
            page.hear(kind)
            watch(page, on=False, camera=kind == "camera", width_px=100)
            assert wait_until(lambda: not hub._busy)
            sent, made = hub.pictures_sent, hub.picture_number
            for _ in range(5):
                site.daemon.cycle()
                page.send(type="ack")
                assert page.hear("state"), "it hears what happens all the same"
            assert (hub.pictures_sent, hub.picture_number) == (sent, made)
            assert hub.pictures == {}, "nothing old is kept"


# A hub in virtual time.


class Virtual:
    """A hub whose clock stands still, and whose pictures are made at once."""

    def __init__(self, viewers: int) -> None:
        self.daemon = FakeDaemon(shown_config(picture_rate_hz=10.0), laboratory())
        self.hub = Hub(self.daemon, clock=self.daemon.clock, wall_clock=lambda: 0.0)
        self.made: list[tuple[str, frozenset[int]]] = []
        self.hub._start = self._start  # type: ignore[method-assign]
        self.viewers = [Attention() for _ in range(viewers)]
        self.hub.viewers = set(self.viewers)

    def _start(self, name: str, work: Any) -> None:
        work.close()
        if name in ("picture", "camera"):
            new = {w for (k, w), f in self.hub._frames.items() if k == name and f is self.frame}
            self.made.append((name, frozenset(new)))

    @property
    def frame(self) -> Frame | None:
        return self.daemon.frame

    def cycle(self) -> None:
        self.daemon.cycle()
        self.hub.look(self.daemon.clock())


def test_nothing_is_made_for_hidden_pages_and_once_for_each_size_of_the_others() -> None:
    virtual = Virtual(6)
    for viewer, width in zip(virtual.viewers, (20, 40, 40, 160, 160, 160), strict=True):
        viewer.width_px = width
    virtual.cycle()
    assert virtual.made == []
    for viewer in virtual.viewers[1:4]:
        viewer.is_watching = True
    virtual.cycle()
    assert virtual.made == [("picture", frozenset({40, 160}))]
    for viewer in virtual.viewers:
        viewer.is_watching = False
    virtual.cycle()
    assert len(virtual.made) == 1
    assert virtual.hub._frames == {}


def test_all_sizes_together_are_made_at_most_as_often_as_the_rate_says() -> None:
    virtual = Virtual(64)
    for number, viewer in enumerate(virtual.viewers):
        viewer.is_watching = True
        viewer.width_px = width_for(1 + 7 * number, MOST_PX)
    cycles = 100
    for _ in range(cycles):
        virtual.cycle()
        for viewer in virtual.viewers:
            if viewer.wants_picture(virtual.daemon.clock(), virtual.hub.picture_pause_s()):
                viewer.shown(virtual.daemon.clock())
                viewer.drawn()
    pictures = sum(len(widths) for _, widths in virtual.made)
    seconds = 0.1 * cycles
    # 64 pages share 120 pictures a second: each has one in 0.53 s, and all are due together
    assert pictures / seconds <= SIZES * 120.0 / 64 / 0.75 + 1.0
    assert all(len(widths) <= SIZES for _, widths in virtual.made)


def test_pages_that_hop_between_sizes_have_each_made_once_a_picture_and_ten_times_a_second() -> (
    None
):
    virtual = Virtual(64)
    for viewer in virtual.viewers[1:]:
        viewer.is_watching = False
    hopping = virtual.viewers[0]
    hopping.is_watching = True
    for look in range(600):  # ten seconds, and no picture is ever taken
        hopping.width_px = width_for(1 + 23 * look % MOST_PX, MOST_PX)
        if look % 6 == 0:
            virtual.daemon.cycle()
        virtual.hub.look(look / 60.0)
    assert len(virtual.made) <= 10.0 * 10.0 / 0.75 + 1.0
    assert sum(len(widths) for _, widths in virtual.made) <= len(virtual.made) * SIZES


def test_who_comes_back_does_not_get_the_picture_of_before(site: Site) -> None:
    hub = site.dashboard.hub
    assert hub is not None
    with site.live() as page:
        watch(page, on=True, width_px=100)
        first = page.hear("picture")
        assert first["arrays"]["jpeg"].size
        watch(page, on=False, width_px=100)
        white = replace(frame(9), image=np.full((360, 480), 255, np.uint8))
        site.daemon.show(frame=white)
        assert wait_until(lambda: not hub.pictures)
        watch(page, on=True, width_px=100)
        page.send(type="ack")
        again = cv2.imdecode(page.hear("picture")["arrays"]["jpeg"], 0)
        assert again[again.shape[0] // 2, 20:80].min() > 250
