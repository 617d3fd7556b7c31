"""The dashboard's server over real sockets: pages, websockets, viewers, refusals, its life."""

import contextlib
import json
import socket
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from navigation.dashboard import Dashboard
from navigation.dashboard.messages.packed import unpack
from navigation.mission.mission import State, Station
from tests.support.runs.shown import FakeDaemon, frame, laboratory, pose, shown_config
from tests.support.waiting import wait_until

TOKEN = "a-token-of-some-length"
VIEWER = "a-token-for-looking"
KEY = "0123456789abcdef"


class Site:
    """A dashboard of a daemon that only shows."""

    def __init__(self, daemon: FakeDaemon) -> None:
        self.daemon = daemon
        self.said: list[str] = []
        self.dashboard = Dashboard(daemon, say=self.said.append)

    def __enter__(self) -> "Site":
        self.dashboard.__enter__()
        assert wait_until(lambda: self.dashboard.hub is not None), self.said
        return self

    def __exit__(self, *_exc: object) -> None:
        self.dashboard.__exit__()

    @property
    def address(self) -> str:
        assert self.dashboard.url is not None
        return self.dashboard.url.split("//")[1].split("/")[0]

    def get(
        self, path: str, method: str = "GET", body: bytes | None = None, **headers: str
    ) -> tuple[int, str, dict[str, str]]:
        names = {name.replace("_", "-"): value for name, value in headers.items()}
        url = f"http://{self.address}{path}"
        request = urllib.request.Request(url, body, names, method=method)
        try:
            with urllib.request.urlopen(request, timeout=10) as answer:
                return (
                    answer.status,
                    answer.read().decode(),
                    {k.lower(): v for k, v in answer.headers.items()},
                )
        except urllib.error.HTTPError as error:
            with error:
                return error.code, error.read().decode(), {}

    def live(self, *protocols: str, origin: str | None = None, **options: Any) -> "Page":
        asked: Any = ["clearway.1", *protocols]
        return Page(
            connect(f"ws://{self.address}/live", subprotocols=asked, origin=origin, **options)  # type: ignore[arg-type]
        )

    def refused(self, kind: str) -> int:
        assert self.dashboard.hub is not None
        return self.dashboard.hub.gate.refused[kind]


class Page:
    """A page that reads everything, and answers nothing by itself."""

    def __init__(self, line: ClientConnection) -> None:
        self.line = line.__enter__()

    def __enter__(self) -> "Page":
        return self

    def __exit__(self, *_exc: object) -> None:
        self.line.close()

    def send(self, **message: object) -> None:
        self.line.send(json.dumps(message))

    def hear(self, kind: str, seconds: float = 10.0) -> dict[str, Any]:
        """The next message of a kind; the arrays of packed ones are under ``arrays``."""
        end_s = time.monotonic() + seconds
        while (left_s := end_s - time.monotonic()) > 0.0:
            data = self.line.recv(left_s)
            if isinstance(data, bytes):
                head, arrays = unpack(data)
                message = {**head, "arrays": arrays}
            else:
                message = json.loads(data)
            if message["type"] == kind:
                return message
        raise AssertionError(f"no {kind} within {seconds} s")

    def join(self, key: str = KEY, name: str = "") -> dict[str, Any]:
        self.send(type="join", key=key, name=name)
        return self.hear("joined")

    def order(self, order: str, **fields: object) -> dict[str, Any]:
        self.send(type="order", id=1, order=order, **fields)
        return self.hear("answer")


@pytest.fixture(scope="module")
def quiet_site() -> Iterator[Site]:
    """One site for tests that leave nothing behind."""
    with Site(FakeDaemon(roadmap=laboratory())) as site:
        yield site


@pytest.fixture
def site() -> Iterator[Site]:
    with Site(FakeDaemon(roadmap=laboratory())) as site:
        yield site


@pytest.fixture
def guarded() -> Iterator[Site]:
    """A site with tokens."""
    with Site(FakeDaemon(shown_config(token=TOKEN, viewer_token=VIEWER))) as site:
        yield site


# Pages.


def test_the_page_and_everything_that_it_names_is_there(quiet_site: Site) -> None:
    status, page, headers = quiet_site.get("/")
    assert status == 200
    assert headers["content-type"] == "text/html; charset=utf-8"
    for name in ("main.js", "style.css", "palette.css", "icon.svg"):
        assert f'"{name}' in page
    seen, waiting = set(), ["/main.js"]
    while waiting:
        name = waiting.pop()
        status, script, headers = quiet_site.get(name)
        assert (status, headers["content-type"]) == (200, "text/javascript; charset=utf-8"), name
        seen.add(name)
        imports = [line.split('"')[-2] for line in script.splitlines() if '} from "./' in line]
        waiting += [f"/{one[2:]}" for one in imports if f"/{one[2:]}" not in seen]
    assert len(seen) >= 12


def test_every_answer_forbids_what_the_page_does_not_need(quiet_site: Site) -> None:
    for path in ("/", "/api/state", "/metrics", "/healthz"):
        headers = quiet_site.get(path)[2]
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert "frame-ancestors 'none'" in policy
        assert headers["x-content-type-options"] == "nosniff"


@pytest.mark.parametrize(
    "path", ["/nothing", "/../server.py", "/..%2fserver.py", "/static/main.js", "/index.html/x"]
)
def test_nothing_else_is_there(path: str, quiet_site: Site) -> None:
    assert quiet_site.get(path)[0] == 404


def test_health_is_told_and_a_hanging_loop_is_503(site: Site) -> None:
    assert wait_until(lambda: site.get("/healthz")[0] == 200)
    assert json.loads(site.get("/healthz")[1])["camera"] == "running"
    # the fake daemon ends no further cycle, so its loop hangs after a second
    assert wait_until(lambda: site.get("/healthz")[0] == 503, 5.0)
    assert "does not answer" in site.get("/healthz")[1]


def test_metrics_have_the_numbers_of_the_state(site: Site) -> None:
    daemon = site.daemon
    daemon.camera = replace(daemon.camera, captured=321, dropped=4)
    assert wait_until(lambda: "clearway_camera_frames_total 321.0" in site.get("/metrics")[1])
    text = site.get("/metrics")[1]
    assert "clearway_camera_frames_dropped_total 4.0" in text
    assert 'clearway_mission_state{state="idle"} 1.0' in text
    assert "clearway_clearance_metres 0.2" in text
    assert "# HELP clearway_link_crc_errors_total Frames that arrived damaged." in text
    for met in ("taken_back", "stray_hellos", "clock_jumps", "stale"):
        assert f"clearway_link_{met}_total 0.0" in text


def test_refusals_are_in_the_metrics(site: Site) -> None:
    site.get("/", Origin="http://evil.example")
    assert 'clearway_dashboard_refused_total{kind="origin"} 1.0' in site.get("/metrics")[1]


def test_a_stop_needs_no_websocket(site: Site) -> None:
    status, answer, _ = site.get("/api/stop", "POST")
    assert (status, json.loads(answer)) == (200, {"ok": True})
    assert site.daemon.orders == [("stop", "stopped by 127.0.0.1")]
    assert site.get("/api/stop", "GET")[0] == 405


# Who may.


def test_foreign_names_and_origins_are_refused_everywhere(site: Site) -> None:
    assert site.get("/", Host="evil.example")[0] == 400
    assert site.get("/api/stop", "POST", Host="evil.example")[0] == 400
    assert site.get("/api/stop", "POST", Origin="http://evil.example")[0] == 403
    with pytest.raises(InvalidStatus) as refused, site.live(origin="http://evil.example"):
        pass
    assert refused.value.response.status_code == 403
    assert (site.refused("host"), site.refused("origin")) == (2, 2)
    assert site.daemon.orders == []


def test_without_the_token_nothing_is_shown_and_nothing_is_taken(guarded: Site) -> None:
    assert guarded.get("/")[0] == 200, "the page itself holds no secret and asks for the token"
    assert guarded.get("/healthz")[0] in (200, 503)
    for path, method in (("/api/state", "GET"), ("/metrics", "GET"), ("/api/stop", "POST")):
        assert guarded.get(path, method)[0] == 401
        assert guarded.get(path, method, Authorization="Bearer wrong")[0] == 403
        assert guarded.get(path, method, Authorization=f"Bearer {TOKEN}")[0] == 200
    for protocols in ([], ["token.wrong"]):
        with pytest.raises(InvalidStatus), guarded.live(*protocols):
            pass
    assert (guarded.refused("no_token"), guarded.refused("token")) == (4, 4)
    with guarded.live(f"token.{TOKEN}") as page:
        assert page.hear("hello")["role"] == "operator"
        assert page.line.subprotocol == "clearway.1", "the token is not sent back"


def test_a_viewers_token_looks_and_stops_but_never_drives(guarded: Site) -> None:
    with guarded.live(f"token.{VIEWER}") as page:
        assert page.hear("hello")["role"] == "viewer"
        page.join()
        page.send(type="take", id=1)
        assert "looking" in page.hear("answer")["error"]
        assert "looking" in page.order("go", stations=[{"x_m": 1, "y_m": 1}])["error"]
        assert page.order("stop")["ok"]
    assert guarded.daemon.orders == [("stop", "stopped by viewer 1")]


def test_only_the_holder_drives_and_everybody_stops(site: Site) -> None:
    goal = [{"x_m": 1.0, "y_m": 0.5}]
    with site.live() as one, site.live() as other:
        one.join("a" * 32, "Ada")
        other.join("b" * 32, "Ben")
        assert other.order("go", stations=goal)["error"] == "take the arena first"
        one.send(type="take", id=1)
        assert one.hear("answer")["ok"]
        other.send(type="take", id=2)
        assert "Ada holds the arena" in other.hear("answer")["error"]
        assert one.order("go", stations=goal)["ok"]
        assert other.order("pause")["error"] == "take the arena first"
        assert other.order("stop")["ok"]
        assert other.order("rearm")["error"] == "take the arena first"
        assert one.order("rearm")["ok"]
        one.send(type="release")
        other.send(type="take", id=3)
        assert other.hear("answer")["ok"]
    assert site.daemon.orders == [(Station(1.0, 0.5),), ("stop", "stopped by Ben"), "resume"]


def test_the_seat_survives_a_reload_and_is_freed_when_the_page_is_closed(site: Site) -> None:
    hub = site.dashboard.hub
    assert hub is not None
    with site.live() as page:
        page.join()
        page.send(type="take", id=1)
        assert page.hear("answer")["ok"]
    with site.live() as page:
        page.join()
        time.sleep(0.3)  # longer than the hub takes to look
        assert hub.seat.is_held_by(KEY)
        page.line.close(1001)
    assert wait_until(lambda: hub.seat.holder is None, 8.0)


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
        assert site.daemon.state is not None
        mission = replace(site.daemon.state.mission, state=State.HOLDING, reason="a new reason")
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
        assert "take the arena" in page.hear("preview")["reason"]
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
    def fail() -> None:
        raise ZeroDivisionError("a test")

    with site.live() as page:
        page.hear("state")
        camera_status = site.daemon.camera_status
        monkeypatch.setattr(site.daemon, "camera_status", fail)
        assert wait_until(lambda: "a test" in str(log_of(site)))
        assert site.get("/api/stop", "POST")[0] == 200
        monkeypatch.setattr(site.daemon, "camera_status", camera_status)
        while page.hear("state")["mission"]["state"] != "stopped":
            pass
    assert sum("a test" in text for text in log_of(site)) == 1


def log_of(site: Site) -> list[str]:
    assert site.dashboard.hub is not None
    return [line.text for line in site.dashboard.hub.chronicle.log.since(0, 500)[1]]


# Its life.


def test_the_address_is_said_and_has_the_token_only_for_a_person() -> None:
    daemon = FakeDaemon(shown_config(token=TOKEN))
    for show in (False, True):
        said: list[str] = []
        with Dashboard(daemon, say=said.append, show_token=show) as dashboard:
            assert said == [f"dashboard at {dashboard.url}"]
            assert (f"#token={TOKEN}" in said[0]) is show


def test_a_busy_port_is_said_and_the_run_goes_on() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        said: list[str] = []
        with Dashboard(FakeDaemon(shown_config(port=port)), say=said.append) as dashboard:
            assert dashboard.url is None
        assert said == [f"no dashboard: 127.0.0.1:{port}: Address already in use; the run goes on"]


def test_a_host_that_is_not_this_machine_is_said_and_the_run_goes_on() -> None:
    said: list[str] = []
    config = shown_config(host="192.0.2.1", token=TOKEN)
    with Dashboard(FakeDaemon(config), say=said.append) as dashboard:
        assert dashboard.url is None
    assert said[0].startswith("no dashboard: 192.0.2.1:0: ")


def test_it_closes_at_once_with_pages_open_and_tells_them() -> None:
    with Site(FakeDaemon()) as site:
        page = site.live()
        page.hear("state")
        began_s = time.monotonic()
        site.dashboard.__exit__()
        assert time.monotonic() - began_s < 1.0
        with pytest.raises(ConnectionClosed) as closed:
            page.hear("never")
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1001
        assert not site.dashboard._thread.is_alive()


def test_before_the_first_cycle_the_page_waits(site: Site) -> None:
    daemon = FakeDaemon()
    daemon.state = None
    with Site(daemon) as waiting:
        assert json.loads(waiting.get("/api/state")[1])["mission"] is None
        assert waiting.get("/healthz")[0] == 503
        assert waiting.get("/metrics")[0] == 200
        with waiting.live() as page:
            assert page.hear("hello")["arena_m"]
