"""What the server and its pages say to each other: states, pictures on credit, nonsense."""

import contextlib
import json
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from navigation.mission.mission import State
from tests.navigation.dashboard.site import KEY, Page, Site
from tests.support.runs.shown import frame, pose
from tests.support.waiting import wait_until

# Messages.


def test_a_page_is_told_everything_at_first(site: Site) -> None:
    with site.live() as page:
        hello = page.hear("hello")
        assert hello["arena_m"] == [0.0, 0.0, 2.4, 1.8]
        assert page.hear("state")["mission"]["state"] == "idle"
        assert page.hear("world")["objects"] == 7
        page.send(type="watch", on=True)
        jpeg = page.hear("picture")["arrays"]["jpeg"].tobytes()
        assert jpeg.startswith(b"\xff\xd8\xff")


def test_a_new_state_is_told_soon(site: Site) -> None:
    with site.live() as page:
        page.hear("state")
        assert site.daemon.robot is not None
        mission = replace(site.daemon.robot.mission, state=State.HOLDING, reason="a new reason")
        site.daemon.show(mission=mission)
        while "a new reason" not in json.dumps(page.hear("log", 1.0)):
            pass
        assert page.hear("state", 1.0)["mission"]["sentence"] == "a new reason"


def test_pictures_are_sent_on_credit(site: Site) -> None:
    hub = site.dashboard.hub
    assert hub is not None
    with site.live() as page, pictures(site):
        page.send(type="watch", on=True)
        for _ in range(2):
            page.hear("picture")
        with pytest.raises((AssertionError, TimeoutError)):
            page.hear("picture", 0.6)
        page.send(type="ack", number=1)
        page.hear("picture")


def test_nobody_who_looks_means_no_pictures(site: Site) -> None:
    hub = site.dashboard.hub
    assert hub is not None
    with site.live() as page, pictures(site):
        for _ in range(5):
            page.hear("state")
        assert hub.picture_number == 0


@contextlib.contextmanager
def pictures(site: Site) -> Iterator[None]:
    """A new picture every 10 ms."""
    stopping = threading.Event()

    def go() -> None:
        number = 1
        while not stopping.wait(0.01):
            number += 1
            site.daemon.show(frame=frame(number, time.monotonic()))

    thread = threading.Thread(target=go)
    thread.start()
    try:
        yield
    finally:
        stopping.set()
        thread.join()


BAD: list[Callable[[Page], None]] = [
    lambda page: page.line.send("no json"),
    lambda page: page.line.send("[1, 2]"),
    lambda page: page.line.send("[" * 60_000),
    lambda page: page.line.send(b"\0\1\2"),
    lambda page: page.line.send('{"type": "nothing"}'),
    lambda page: page.line.send("{}"),
    lambda page: page.send(type="join", key=7),
    lambda page: page.send(type="join", key="short"),
    lambda page: page.send(type="join", key=KEY, name="n" * 41),
    lambda page: page.send(type="join", key=KEY, name="a\nb"),
    lambda page: page.send(type="preview", stations="here"),
    lambda page: page.send(type="preview", stations=[{"x_m": "NaN", "y_m": 1}]),
    lambda page: page.line.send('{"type": "preview", "stations": [{"x_m": NaN, "y_m": 1}]}'),
    lambda page: page.send(type="take", id=1),
]


@pytest.mark.parametrize("number", range(len(BAD)))
def test_what_is_malformed_is_refused_counted_and_survived(number: int, quiet_site: Site) -> None:
    before = quiet_site.refused("malformed")
    with quiet_site.live() as page:
        BAD[number](page)
        assert page.hear("error")["error"]
        assert quiet_site.refused("malformed") == before + 1
        page.send(type="ping", id=5)
        assert page.hear("pong")["id"] == 5
    assert quiet_site.daemon.orders == []


@pytest.mark.parametrize(
    "stations",
    [None, [], "x", [{"x_m": 1}], [{"x_m": 1e400, "y_m": 1}], [{"x_m": 9.0, "y_m": 9.0}]],
)
def test_an_order_that_cannot_be_is_answered_with_the_reason(stations: object, site: Site) -> None:
    with site.live() as page:
        page.join()
        page.send(type="take", id=1)
        page.hear("answer")
        answer = page.order("go", stations=stations)
        assert not answer["ok"]
        assert "station" in answer["error"]
    assert site.daemon.orders == []


@pytest.mark.parametrize("size", [70_000, 3_000_000])
def test_an_oversized_message_ends_the_connection_and_is_counted(size: int, site: Site) -> None:
    told, tries = None, 0
    while told is None and tries < 5:
        tries += 1
        with site.live() as page:
            page.hear("hello")
            with contextlib.suppress(ConnectionClosed):
                page.line.send("x" * size)
            with pytest.raises(ConnectionClosed) as closed:
                page.hear("never")
            # a reset, while there is still something to send, may swallow the last words
            told = closed.value.rcvd
    assert told is not None
    assert told.code == 1009
    assert wait_until(lambda: site.refused("oversized") == tries)
    assert site.get("/api/stop", "POST", b"x" * 10_000)[0] == 413
    assert site.refused("oversized") == tries + 1
    assert site.daemon.orders == []


def test_who_goes_on_with_nonsense_is_cut_off(site: Site) -> None:
    with site.live() as page:
        with contextlib.suppress(ConnectionClosed):
            for _ in range(40):
                page.line.send("nonsense")
        with pytest.raises(ConnectionClosed) as closed:
            page.hear("never")
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1008


def test_a_preview_changes_nothing_and_is_for_the_holder(site: Site) -> None:
    goal = [{"x_m": 0.2, "y_m": 0.9}]
    with site.live() as page:
        page.join()
        page.send(type="preview", id=1, stations=goal)
        assert "take control" in page.hear("preview")["reason"]
        page.send(type="take", id=2)
        page.hear("answer")
        page.send(type="preview", id=3, stations=goal)
        preview = page.hear("preview", 60.0)
        assert (preview["id"], preview["ok"]) == (3, True)
        assert preview["length_m"] >= 0.7
        assert preview["clearance_m"] >= preview["radius_m"]
    assert site.daemon.orders == []


def test_a_name_is_text_whatever_is_in_it(site: Site) -> None:
    name = "<img src=x onerror=1>"
    with site.live() as page:
        page.join(name=name)
        page.send(type="take", id=1)
        assert page.hear("answer")["ok"]
        page.hear("state")
        assert page.hear("state")["seat"]["name"] == name


def test_another_robot_stays_where_it_was_seen_last(site: Site) -> None:
    other = replace(pose(1.0, 1.0), id=3)
    site.daemon.show(poses={7: pose(), 3: other})
    with site.live() as page:
        while not page.hear("state", 2.0)["others"]:
            pass
        site.daemon.show(poses={7: pose()})
        told = [page.hear("state") for _ in range(3)][-1]
        assert [(one["id"], one["x_m"]) for one in told["others"]] == [(3, 1.0)]


# Many, slow and gone.


def test_twenty_viewers_get_pictures_and_one_that_is_slow_harms_nobody(site: Site) -> None:
    hub = site.dashboard.hub
    assert hub is not None
    with contextlib.ExitStack() as opened:
        slow = opened.enter_context(site.live(max_queue=1))
        slow.send(type="watch", on=True)  # and never reads again
        pages = [opened.enter_context(site.live()) for _ in range(20)]
        opened.enter_context(pictures(site))
        counts = [0] * len(pages)

        def look(index: int) -> None:
            page = pages[index]
            page.send(type="watch", on=True)
            while counts[index] < 5:
                page.send(type="ack", number=page.hear("picture")["number"])
                counts[index] += 1

        threads = [threading.Thread(target=look, args=(i,)) for i in range(len(pages))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(30.0)
        assert counts == [5] * 20
        assert len(hub.viewers) == 21
        slow.line.close_socket() if hasattr(slow.line, "close_socket") else slow.line.socket.close()
    assert wait_until(lambda: not hub.viewers)


def test_the_sixty_fifth_viewer_is_refused(site: Site) -> None:
    with contextlib.ExitStack() as opened:
        for _ in range(64):
            opened.enter_context(site.live())
        with pytest.raises(InvalidStatus) as refused, site.live():
            pass
        assert refused.value.response.status_code == 503
        assert site.get("/api/stop", "POST")[0] == 200, "a stop has no queue"


def test_a_page_of_another_version_is_told_to_load_again(site: Site) -> None:
    with pytest.raises(InvalidStatus) as refused:
        Page(connect(f"ws://{site.address}/live", subprotocols=["clearway.0"]))  # type: ignore[list-item]
    assert refused.value.response.status_code == 400
    assert b"load the page again" in (refused.value.response.body or b"")


def test_an_error_of_the_page_is_said_in_its_log_and_stop_goes_on(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    fails: list[int] = []

    def fail() -> None:
        fails.append(len(fails))
        raise ZeroDivisionError("a test")

    with site.live() as page:
        page.hear("state")
        camera_status = site.daemon.camera_status
        monkeypatch.setattr(site.daemon, "camera_status", fail)
        assert wait_until(lambda: len(fails) > 3)
        assert site.get("/api/stop", "POST")[0] == 200
        monkeypatch.setattr(site.daemon, "camera_status", camera_status)
        while page.hear("state")["mission"]["state"] != "stopped":
            pass
    texts = log_of(site)
    assert any("a test" in text for text in texts)
    assert all(one != following for one, following in pairwise(texts)), "once in a row"


def log_of(site: Site) -> list[str]:
    assert site.dashboard.hub is not None
    return [line.text for line in site.dashboard.hub.chronicle.log.since(0, 500)[1]]
