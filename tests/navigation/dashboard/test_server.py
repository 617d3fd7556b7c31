"""The dashboard's server over real sockets: pages, websockets, viewers, refusals, its life."""

import json
import socket
import time
from dataclasses import replace

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from navigation.dashboard import Dashboard
from navigation.mission.mission import Station
from tests.navigation.dashboard.site import KEY, TOKEN, VIEWER, Site
from tests.support.runs.shown import FakeDaemon, shown_config
from tests.support.waiting import wait_until

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
    assert guarded.daemon.orders == [("stop", "stopped by somebody")]


def test_only_the_holder_drives_and_everybody_stops(site: Site) -> None:
    goal = [{"x_m": 1.0, "y_m": 0.5}]
    with site.live() as one, site.live() as other:
        one.join("a" * 32, "Ada")
        other.join("b" * 32, "Ben")
        assert other.order("go", stations=goal)["error"] == "take control first"
        one.send(type="take", id=1)
        assert one.hear("answer")["ok"]
        other.send(type="take", id=2)
        assert "Ada is in control" in other.hear("answer")["error"]
        assert one.order("go", stations=goal)["ok"]
        assert other.order("pause")["error"] == "take control first"
        assert other.order("stop")["ok"]
        assert other.order("rearm")["error"] == "take control first"
        assert one.order("rearm")["ok"]
        one.send(type="release")
        other.send(type="take", id=3)
        assert other.hear("answer")["ok"]
    assert site.daemon.orders == [
        ("give", (Station(1.0, 0.5),)),
        ("stop", "stopped by Ben"),
        ("resume",),
    ]


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
        assert said == [
            f"no dashboard: 127.0.0.1:{port}: Address already in use; the run continues"
        ]


def test_a_host_that_is_not_this_machine_is_said_and_the_run_goes_on() -> None:
    said: list[str] = []
    config = shown_config(host="192.0.2.1", token=TOKEN)
    with Dashboard(FakeDaemon(config), say=said.append) as dashboard:
        assert dashboard.url is None
    assert said[0].startswith("no dashboard: 192.0.2.1:0: ")


@pytest.mark.timed  # says how soon the page closes
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
    daemon.robot = None
    with Site(daemon) as waiting:
        assert json.loads(waiting.get("/api/state")[1])["mission"] is None
        assert waiting.get("/healthz")[0] == 503
        assert waiting.get("/metrics")[0] == 200
        with waiting.live() as page:
            assert page.hear("hello")["arena_m"]
