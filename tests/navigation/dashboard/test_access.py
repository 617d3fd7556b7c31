"""Who may reach the dashboard, who holds the arena, and what each may order."""

import pytest

from navigation.config import ConfigError
from navigation.config.dashboard import DashboardSection
from navigation.dashboard.admission.access import AccessGate, Refusal, Role, bearer_of, token_of
from navigation.dashboard.admission.seat import AWAY_S, LEFT_S, Seat, public_half
from navigation.dashboard.orders import give, refusal_of
from navigation.mission.mission import MissionProgress, State, Station
from tests.support.runs.shown import FakeDaemon, shown_config

TOKEN, OTHER = "a-token-of-some-length", "another-token-to-look"
KEY, ELSE = "k" * 32, "e" * 32


# Host and Origin.


@pytest.mark.parametrize("host", ["127.0.0.1:8421", "localhost:8421", "[::1]:8421", "LOCALHOST"])
def test_this_machines_own_names_are_let_in(host: str) -> None:
    assert AccessGate(DashboardSection()).admit(host, None) is None


@pytest.mark.parametrize(
    "host",
    [None, "", "evil.example", "evil.example:8421", "127.0.0.1.evil.example", "192.168.1.5", "[::"],
)
def test_a_foreign_name_is_refused_with_400_and_counted(host: str | None) -> None:
    gate = AccessGate(DashboardSection())
    refusal = gate.admit(host, None)
    assert refusal is not None
    assert (refusal.status, gate.refused["host"]) == (400, 1)


def test_further_names_come_from_the_configuration() -> None:
    gate = AccessGate(DashboardSection(names=("arena.example",)))
    assert gate.admit("Arena.Example:443", None) is None


def test_an_open_dashboard_is_reached_by_any_address_but_by_no_foreign_name() -> None:
    gate = AccessGate(DashboardSection(host="0.0.0.0", token=TOKEN))
    assert gate.admit("192.168.1.5:8421", None) is None
    assert gate.admit("[fe80::1]:8421", None) is None
    assert gate.admit("evil.example:8421", None) is not None


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "null",
        "http://127.0.0.1:9999",
        "http://127.0.0.1",
        "http://127.0.0.1:8421.evil.example",
        "",
    ],
)
def test_another_origin_is_refused_with_403_and_counted(origin: str) -> None:
    gate = AccessGate(DashboardSection())
    refusal = gate.admit("127.0.0.1:8421", origin)
    assert refusal is not None
    assert (refusal.status, gate.refused["origin"]) == (403, 1)


@pytest.mark.parametrize("scheme", ["http", "https"])
def test_the_pages_own_origin_is_let_in(scheme: str) -> None:
    assert (
        AccessGate(DashboardSection()).admit("localhost:8421", f"{scheme}://localhost:8421") is None
    )


# Tokens.


def test_without_a_token_in_the_configuration_everybody_may_drive() -> None:
    assert AccessGate(DashboardSection()).role(None) is Role.OPERATOR


def test_tokens_tell_operators_from_viewers_and_the_rest_is_refused_and_counted() -> None:
    gate = AccessGate(DashboardSection(token=TOKEN, viewer_token=OTHER))
    assert gate.role(TOKEN) is Role.OPERATOR
    assert gate.role(OTHER) is Role.VIEWER
    for bad, status in ((None, 401), ("", 403), (TOKEN[:-1], 403), (TOKEN + "x", 403), ("ä", 403)):
        refusal = gate.role(bad)
        assert isinstance(refusal, Refusal)
        assert refusal.status == status
    assert gate.refused == {"no_token": 1, "token": 4}


def test_a_token_is_found_in_the_subprotocols_and_in_the_header() -> None:
    assert token_of(["clearway.1", f"token.{TOKEN}"]) == TOKEN
    assert token_of(["clearway.1"]) is None
    assert bearer_of(f"Bearer {TOKEN}") == TOKEN
    assert bearer_of(f"Basic {TOKEN}") is None
    assert bearer_of(None) is None


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.5", "::", "arena.example"])
def test_a_dashboard_that_others_reach_needs_a_token(host: str) -> None:
    with pytest.raises(ConfigError, match=r"dashboard\.host.*needs dashboard\.token"):
        shown_config(host=f"'{host}'")
    assert shown_config(host=f"'{host}'", token=TOKEN).dashboard.token == TOKEN


def test_a_dashboard_that_is_switched_off_needs_no_token() -> None:
    assert not shown_config(host="0.0.0.0", enabled="false").dashboard.enabled


@pytest.mark.parametrize("token", ["short", "with space in it, long enough", "ends-with-a-hash-#"])
def test_a_weak_token_or_one_that_needs_quoting_is_no_token(token: str) -> None:
    with pytest.raises(ConfigError, match="token"):
        shown_config(token=f"'{token}'")


def test_the_viewers_token_must_be_another_one() -> None:
    with pytest.raises(ConfigError, match="must differ"):
        shown_config(token=TOKEN, viewer_token=TOKEN)
    with pytest.raises(ConfigError, match=r"needs dashboard\.token"):
        shown_config(viewer_token=TOKEN)


# The seat.


def test_one_at_a_time_holds_the_arena() -> None:
    seat = Seat(300.0)
    assert seat.take(KEY, "Ada", 0.0) is None
    assert seat.take(KEY, "Ada", 1.0) is None, "again is no mistake"
    refusal = seat.take(ELSE, "Ben", 2.0)
    assert refusal is not None
    assert "Ada is in control" in refusal
    assert not seat.release(ELSE)
    assert seat.release(KEY)
    assert seat.take(ELSE, "Ben", 3.0) is None


def test_who_does_nothing_loses_the_arena_and_each_order_keeps_it() -> None:
    seat = Seat(300.0)
    seat.take(KEY, "Ada", 0.0)
    seat.touch(KEY, 200.0)
    assert seat.tick(499.9) is None
    told = seat.tick(500.0)
    assert told == "Ada did nothing for a while: no one is in control"
    assert seat.holder is None


@pytest.mark.parametrize(("left", "patience_s"), [(True, LEFT_S), (False, AWAY_S)])
def test_a_page_that_comes_back_in_time_is_the_same_operator(left: bool, patience_s: float) -> None:
    seat = Seat(300.0)
    seat.take(KEY, "Ada", 0.0)
    seat.go(KEY, 10.0, left=left)
    assert seat.tick(10.0 + patience_s - 0.1) is None
    seat.come(KEY, "Ada")
    assert seat.tick(10.0 + patience_s + 50.0) is None
    seat.go(KEY, 100.0, left=left)
    assert seat.tick(100.0 + patience_s) == "Ada went away: no one is in control"


def test_the_comings_and_goings_of_others_do_not_touch_the_seat() -> None:
    seat = Seat(300.0)
    seat.take(KEY, "Ada", 0.0)
    seat.go(ELSE, 1.0, left=True)
    seat.touch(ELSE, 2.0)
    seat.come(ELSE, "Ben")
    assert seat.free_in_s(2.0) == pytest.approx(298.0)


def test_what_others_see_of_the_key_does_not_give_it_away() -> None:
    assert KEY not in public_half(KEY)
    assert public_half(KEY) != public_half(ELSE)


# Orders.


def test_everybody_may_stop_and_only_the_holder_may_drive() -> None:
    for may_drive in (False, True):
        for holds in (False, True):
            assert refusal_of("stop", may_drive=may_drive, holds=holds) is None
    for order in ("go", "pause", "resume", "rearm", "replan"):
        assert refusal_of(order, may_drive=True, holds=True) is None
        assert refusal_of(order, may_drive=True, holds=False) == "take control first"
        assert "looking" in (refusal_of(order, may_drive=False, holds=True) or "")


@pytest.mark.parametrize("order", [None, "", "fly", 7, ["go"], {"stop": 1}])
def test_an_order_that_is_none_is_refused(order: object) -> None:
    assert "must be" in (refusal_of(order, may_drive=True, holds=True) or "")


def test_a_stop_is_left_by_rearm_only() -> None:
    daemon = FakeDaemon()
    daemon.people.stop("a test")
    for order in ("resume", "go"):
        answer = give({"order": order, "stations": []}, daemon.people, "Ada")
        assert not answer["ok"]
        assert "re-arm" in answer["error"]
    assert give({"order": "rearm"}, daemon.people, "Ada")["ok"]
    assert daemon.orders == [("stop", "a test"), ("resume",)]


def test_rearm_pressed_twice_does_not_set_the_robot_going() -> None:
    daemon = FakeDaemon()
    daemon.people.stop("a test")
    assert give({"order": "rearm"}, daemon.people, "Ada")["ok"]
    assert not give({"order": "rearm"}, daemon.people, "Ada")["ok"]
    assert daemon.orders.count(("resume",)) == 1


@pytest.mark.parametrize("state", [s for s in State if s is not State.STOPPED])
def test_there_is_nothing_to_rearm_without_a_stop(state: State) -> None:
    daemon = FakeDaemon()
    daemon.show(mission=MissionProgress(state=state))
    assert not give({"order": "rearm"}, daemon.people, "Ada")["ok"]
    assert daemon.orders == []


def test_a_stop_says_who_stopped_and_takes_no_words_from_the_page() -> None:
    daemon = FakeDaemon()
    assert give({"order": "stop", "reason": "x" * 9999}, daemon.people, "Ada")["ok"]
    assert daemon.orders == [("stop", "stopped by Ada")]


def test_an_order_to_go_reaches_the_daemon_with_its_stations() -> None:
    daemon = FakeDaemon()
    stations = [{"x_m": 1.0, "y_m": 0.5, "heading_rad": None, "dwell_s": 0.0}]
    assert give({"order": "go", "stations": stations, "id": 3}, daemon.people, "Ada")["ok"]
    assert daemon.orders == [("give", (Station(1.0, 0.5),))]
