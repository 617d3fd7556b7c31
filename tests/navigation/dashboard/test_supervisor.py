"""A supervisor's token: takes control from anyone at once, and both pages hear one sentence."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest
from websockets.exceptions import InvalidStatus

from navigation.config import ConfigError
from navigation.config.dashboard import DashboardSection
from navigation.dashboard.admission.access import AccessGate, Refusal, Role
from navigation.dashboard.admission.seat import Seat
from tests.navigation.dashboard.site import TOKEN, VIEWER, Page, Site
from tests.support.runs.shown import FakeDaemon, laboratory, shown_config
from tests.support.waiting import wait_until

SUPERVISOR = "a-token-for-the-teacher"
ADA, TEACHER, ELSE = "a" * 32, "t" * 32, "e" * 32
SENTENCE = "the supervisor Ms Lee has taken control from Ada"


@pytest.fixture
def classroom() -> Iterator[Site]:
    """A site with a token for each role."""
    config = shown_config(token=TOKEN, viewer_token=VIEWER, supervisor_token=SUPERVISOR)
    with Site(FakeDaemon(config, laboratory())) as site:
        yield site


def take(page: Page) -> dict[str, object]:
    page.send(type="take", id=1)
    answer = page.hear("answer")
    return {key: answer[key] for key in ("ok", "error") if key in answer}


def log_of(site: Site) -> list[str]:
    assert site.dashboard.hub is not None
    return [line.text for line in site.dashboard.hub.chronicle.log.since(0, 1000)[1]]


# Rules, without a page.


def test_only_a_supervisor_takes_a_seat_that_is_held() -> None:
    seat = Seat(300.0)
    assert seat.take(ADA, "Ada", 0.0) is None
    assert seat.take(TEACHER, "Ms Lee", 1.0) is not None
    assert seat.take(TEACHER, "Ms Lee", 1.0, from_anyone=True) is None
    assert seat.is_held_by(TEACHER)
    assert "Ms Lee is in control" in (seat.take(ADA, "Ada", 2.0) or "")
    assert seat.free_in_s(2.0) == pytest.approx(299.0), "her time begins when she takes it"
    assert not seat.release(ADA)
    assert seat.release(TEACHER)


def test_the_one_who_lost_it_neither_keeps_nor_frees_it() -> None:
    seat = Seat(300.0)
    seat.take(ADA, "Ada", 0.0)
    seat.take(TEACHER, "Ms Lee", 1.0, from_anyone=True)
    seat.go(ADA, 2.0, left=True)
    seat.touch(ADA, 100.0)
    assert seat.tick(250.0) is None
    assert seat.tick(301.0) is not None


def test_roles_are_ranked_and_two_of_them_drive() -> None:
    assert Role.OPERATOR.may_less_than(Role.SUPERVISOR)
    assert [role for role in Role if role.may_drive] == [Role.OPERATOR, Role.SUPERVISOR]


def test_a_token_is_of_one_role_and_a_wrong_one_of_none() -> None:
    gate = AccessGate(
        DashboardSection(token=TOKEN, viewer_token=VIEWER, supervisor_token=SUPERVISOR)
    )
    assert gate.role(SUPERVISOR) is Role.SUPERVISOR
    assert gate.role(TOKEN) is Role.OPERATOR
    assert gate.role(VIEWER) is Role.VIEWER
    for wrong in ("", SUPERVISOR[:-1], SUPERVISOR + "x", SUPERVISOR.upper(), "\udcff"):
        refusal = gate.role(wrong)
        assert isinstance(refusal, Refusal)
        assert refusal.status == 403
    without = AccessGate(DashboardSection(token=TOKEN))
    assert isinstance(without.role(SUPERVISOR), Refusal)


@pytest.mark.parametrize(
    ("tokens", "said"),
    [
        ({"token": TOKEN, "supervisor_token": TOKEN}, "must differ from dashboard.token"),
        (
            {"token": TOKEN, "viewer_token": VIEWER, "supervisor_token": VIEWER},
            "must differ from dashboard.viewer_token",
        ),
        ({"supervisor_token": SUPERVISOR}, "needs dashboard.token"),
        ({"token": TOKEN, "supervisor_token": "short"}, "supervisor_token"),
    ],
)
def test_one_token_for_two_roles_is_refused(tokens: dict[str, str], said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        shown_config(**tokens)
    assert said in str(caught.value)
    assert "dashboard.supervisor_token" in str(caught.value)


# Two pages.


def test_a_supervisor_takes_control_at_once_and_both_and_the_log_say_so(classroom: Site) -> None:
    with classroom.live(f"token.{TOKEN}") as student, classroom.live(f"token.{SUPERVISOR}") as one:
        student.join(ADA, "Ada")
        one.join(TEACHER, "Ms Lee")
        assert one.hear("state")["seat"] is None
        assert take(student) == {"ok": True}
        assert student.order("go", stations=[{"x_m": 1.0, "y_m": 0.5}])["ok"]
        assert take(one) == {"ok": True}
        assert one.hear("notice")["text"] == SENTENCE
        assert student.hear("notice")["text"] == SENTENCE
        assert student.hear("state")["seat"]["name"] == "Ms Lee"
        assert log_of(classroom).count(SENTENCE) == 1
        assert student.order("pause")["error"] == "take control first"
        assert "Ms Lee is in control" in str(take(student)["error"])
        orders = len(classroom.daemon.orders)
        assert orders == 1, "taking control orders nothing"
        assert one.order("pause")["ok"]
        one.send(type="release")
        assert wait_until(lambda: "Ms Lee left the arena free" in log_of(classroom))
        assert take(student) == {"ok": True}


def test_the_others_hear_nothing_and_a_second_take_is_no_news(classroom: Site) -> None:
    with (
        classroom.live(f"token.{TOKEN}") as student,
        classroom.live(f"token.{TOKEN}") as other,
        classroom.live(f"token.{SUPERVISOR}") as one,
    ):
        student.join(ADA, "Ada")
        other.join(ELSE, "Ben")
        one.join(TEACHER, "Ms Lee")
        take(student)
        take(one)
        take(one)
        other.send(type="ping", id=9)
        kinds = set()
        while "pong" not in kinds:
            data = other.line.recv(60.0)
            kinds.add(json.loads(data)["type"] if isinstance(data, str) else "packed")
        assert "notice" not in kinds
        assert log_of(classroom).count(SENTENCE) == 1


def test_who_has_said_no_name_is_the_supervisor(classroom: Site) -> None:
    with classroom.live(f"token.{TOKEN}") as student, classroom.live(f"token.{SUPERVISOR}") as one:
        student.join(ADA)
        one.join(TEACHER)
        take(student)
        take(one)
        assert student.hear("notice")["text"] == "the supervisor has taken control from somebody"


def test_a_free_arena_is_taken_as_by_anyone(classroom: Site) -> None:
    with classroom.live(f"token.{SUPERVISOR}") as one:
        assert one.hear("hello")["role"] == "supervisor"
        one.join(TEACHER, "Ms Lee")
        assert take(one) == {"ok": True}
        assert log_of(classroom)[-1] == "Ms Lee is in control"
        with classroom.live(f"token.{SUPERVISOR}") as second:
            second.join(ELSE, "Mr Fox")
            assert take(second) == {"ok": True}
            sentence = "the supervisor Mr Fox has taken control from Ms Lee"
            assert one.hear("notice")["text"] == sentence


def test_an_operator_who_is_away_loses_it_all_the_same(classroom: Site) -> None:
    hub = classroom.dashboard.hub
    assert hub is not None
    with classroom.live(f"token.{SUPERVISOR}") as one:
        with classroom.live(f"token.{TOKEN}") as student:
            student.join(ADA, "Ada")
            take(student)
        one.join(TEACHER, "Ms Lee")
        assert take(one) == {"ok": True}
        with classroom.live(f"token.{TOKEN}") as student:
            student.join(ADA, "Ada")
            assert student.order("pause")["error"] == "take control first"


@pytest.mark.parametrize("token", [TOKEN, VIEWER])
def test_no_other_token_takes_what_is_held(token: str, classroom: Site) -> None:
    with classroom.live(f"token.{SUPERVISOR}") as one, classroom.live(f"token.{token}") as other:
        one.join(TEACHER, "Ms Lee")
        take(one)
        other.join(ELSE, "Ben")
        other.send(type="take", id=1, from_anyone=True, role="supervisor")
        assert not other.hear("answer")["ok"]
        assert one.order("pause")["ok"]


def test_a_wrong_token_is_refused_at_the_door(classroom: Site) -> None:
    for wrong in (SUPERVISOR[:-1], SUPERVISOR + "x", "x" * 32):
        with pytest.raises(InvalidStatus) as refused, classroom.live(f"token.{wrong}"):
            pass
        assert refused.value.response.status_code == 403
    assert classroom.refused("token") == 3


def test_stop_is_for_all_whoever_is_in_control(classroom: Site) -> None:
    with classroom.live(f"token.{SUPERVISOR}") as one, classroom.live(f"token.{VIEWER}") as viewer:
        one.join(TEACHER, "Ms Lee")
        take(one)
        viewer.join(ELSE, "Ben")
        assert viewer.order("stop")["ok"]
        for token in (TOKEN, VIEWER, SUPERVISOR):
            status, answer, _ = classroom.get("/api/stop", "POST", Authorization=f"Bearer {token}")
            assert (status, json.loads(answer)["ok"]) == (200, True)
    assert len(classroom.daemon.orders) == 4


def test_a_supervisor_may_what_operators_may(classroom: Site) -> None:
    with classroom.live(f"token.{SUPERVISOR}") as one:
        one.join(TEACHER, "Ms Lee")
        take(one)
        stations = [{"x_m": 0.3, "y_m": 1.5}]
        one.send(type="preview", id=2, stations=stations)
        assert one.hear("preview")["ok"]
        one.send(type="place", id=3, do="save", name="door", x_m=1.0, y_m=0.5, heading_rad=None)
        assert "token" not in str(one.hear("answer").get("error", ""))
        assert one.order("go", stations=stations)["ok"]
