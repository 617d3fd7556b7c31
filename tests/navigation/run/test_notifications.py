"""Word to people elsewhere: once for each end of a mission, with its sentence, robot and time."""

from __future__ import annotations

import io
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from navigation.config.notify import NotifySection
from navigation.config.secrecy.secrets import learn
from navigation.loop.run_state import RunState
from navigation.machine.logs import EventLog, RunLog
from navigation.machine.outside_calls import OutsideCall
from navigation.mission.mission import MissionProgress, State, Station
from navigation.run import notifications
from navigation.run.notifications import Notifications, filled
from tests.navigation.machine.test_outside_calls import receiving

NOW = datetime(2026, 3, 1, 12, 0, 5, tzinfo=UTC)
COMMAND = ("tell", "{robot}", "{state}", "{sentence}", "{time}", "{ left } as it is")


class Kept:
    """Calls that are only noted; ``failed`` is said of them."""

    made: list[OutsideCall]

    def __init__(self, _within_s: float) -> None:
        Kept.made = []
        self.failed: list[str] = []

    def __enter__(self) -> Kept:
        return self

    def __exit__(self, *_exc: object) -> None:
        self.failed.append("tell: exited with 1")

    def put(self, call: OutsideCall) -> None:
        self.made.append(call)

    def news(self) -> list[str]:
        said, self.failed = self.failed, []
        return said


@pytest.fixture
def kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notifications, "OutsideCalls", Kept)


def robots(**each: tuple[State, str] | MissionProgress) -> RunState:
    """A cycle's end; of a lone robot with the name ``lone``."""
    found = {}
    for name, one in each.items():
        mission = one if isinstance(one, MissionProgress) else MissionProgress((), 0, False, *one)
        snapshot = SimpleNamespace(mission=mission, sentence=mission.reason)
        found["" if name == "lone" else name] = snapshot
    return cast("RunState", SimpleNamespace(robots=found))


def made_by(section: NotifySection, look: Callable[[Notifications], None]) -> tuple[str, list[str]]:
    """The log and the lines for the terminal."""
    text, lines = io.StringIO(), list[str]()
    log = RunLog(EventLog(text, "text", now=lambda: NOW))
    with Notifications(section, log, lines.append, lambda: NOW) as told:
        look(told)
    return text.getvalue(), lines


def told_words(*cycles: RunState) -> list[tuple[str, ...]]:
    """What a command is called with, without its program."""

    def look(told: Notifications) -> None:
        for cycle in cycles:
            told.cycle(cycle)

    made_by(NotifySection(command=COMMAND), look)
    return [call.command[1:] for call in Kept.made]


DRIVING = State.DRIVING, "driving"
DONE = State.DONE, "at the goal"


@pytest.mark.usefixtures("kept")
@pytest.mark.parametrize("state", list(State))
def test_a_robot_alone_calls_once_when_it_is_done_stopped_or_failed(state: State) -> None:
    end = robots(lone=(state, "a sentence"))
    words = told_words(robots(lone=(State.PLANNING, "planning")), end, end, end)
    if state not in (State.DONE, State.STOPPED, State.FAILED):
        assert words == []
        return
    ((robot, told, sentence, time, left),) = words
    assert (robot, told, sentence) == ("robot", state.value, "a sentence")
    assert datetime.fromisoformat(time) == NOW
    assert left == "{ left } as it is"


@pytest.mark.usefixtures("kept")
def test_another_sentence_of_the_same_state_is_no_call() -> None:
    stopped = [robots(lone=(State.STOPPED, f"stopping, {k}")) for k in range(3)]
    words = told_words(robots(lone=DRIVING), *stopped)
    assert [one[2] for one in words] == ["stopping, 0"]


@pytest.mark.usefixtures("kept")
def test_each_end_of_each_robot_is_a_call_of_its_own() -> None:
    words = told_words(
        robots(ada=DRIVING, bob=DRIVING),
        robots(ada=DONE, bob=DRIVING),
        robots(ada=DONE, bob=(State.STOPPED, "stopped by Eve")),
        robots(ada=DONE, bob=(State.IDLE, "re-armed by hand")),
        robots(ada=(State.PLANNING, "a mission was given"), bob=(State.STOPPED, "again")),
        robots(ada=(State.FAILED, "given up"), bob=(State.STOPPED, "again")),
    )
    assert [one[:3] for one in words] == [
        ("ada", "done", "at the goal"),
        ("bob", "stopped", "stopped by Eve"),
        ("bob", "stopped", "again"),
        ("ada", "failed", "given up"),
    ]


@pytest.mark.usefixtures("kept")
@pytest.mark.parametrize("state", [State.DONE, State.STOPPED, State.FAILED])
def test_what_was_over_when_the_program_began_is_no_news(state: State) -> None:
    assert told_words(*[robots(lone=(state, "as the journal has it"))] * 3) == []


@pytest.mark.usefixtures("kept")
def test_a_robot_that_steps_aside_and_comes_back_is_not_done_twice() -> None:
    there = (Station(1.0, 1.0),)
    done = MissionProgress(there, 1, False, *DONE)
    aside = done.stepping_aside(Station(1.0, 1.0), "aside for bob")
    back = MissionProgress(there, 1, False, *DONE)
    driving = MissionProgress(there, 0, False, *DRIVING)
    words = told_words(*(robots(ada=one) for one in (driving, done, aside, back, back)))
    assert len(words) == 1
    stopped = MissionProgress(there, 1, False, State.STOPPED, "stopped", errand=aside.errand)
    assert len(told_words(robots(ada=aside), robots(ada=stopped))) == 1


@pytest.mark.usefixtures("kept")
def test_a_run_that_fails_by_its_time_limit_calls_for_who_was_under_way() -> None:
    def look(told: Notifications) -> None:
        told.cycle(robots(ada=DONE, bob=DRIVING))
        told.end(State.FAILED, "not done within 60 s")

    made_by(NotifySection(command=COMMAND), look)
    assert [call.command[1:4] for call in Kept.made] == [("bob", "failed", "not done within 60 s")]
    made_by(NotifySection(command=COMMAND), lambda told: told.end(State.STOPPED, "interrupted"))
    assert Kept.made == []


@pytest.mark.usefixtures("kept")
def test_a_call_that_fails_is_one_line_in_the_log_and_one_on_the_terminal() -> None:
    log, lines = made_by(NotifySection(command=COMMAND), lambda told: told.cycle(robots()))
    assert lines == ["a notification failed: tell: exited with 1"]
    assert log.count("\n") == 1
    assert 'warning notify reason="tell: exited with 1"' in log


def test_without_a_command_or_url_no_thread_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notifications, "OutsideCalls", None)
    assert made_by(NotifySection(), lambda told: told.cycle(robots(lone=DONE))) == ("", [])


@pytest.mark.usefixtures("kept")
def test_no_secret_and_no_line_break_leaves_in_a_sentence() -> None:
    learn(["a-secret-of-the-configuration"])
    sentence = "camera at rtsp://me:a-secret-of-the-configuration@cam/\nlost\udcff{robot}"
    ((_, _, told, _, _),) = told_words(robots(lone=DRIVING), robots(lone=(State.FAILED, sentence)))
    assert "a-secret" not in told
    assert told.isprintable()
    assert told.endswith("{robot}"), "a value has no placeholders"


def test_a_value_is_filled_in_once() -> None:
    values = {"state": "{robot}", "robot": "ada", "sentence": "", "time": ""}
    assert filled("{state}{sentence}-{robot}", values) == "{robot}-ada"


def test_a_post_has_state_robot_sentence_and_time() -> None:
    with receiving() as server:

        def look(told: Notifications) -> None:
            told.cycle(robots(ada=DRIVING))
            told.cycle(robots(ada=DONE))

        log, lines = made_by(NotifySection(url=server.url), look)
        ((_, _, body),) = server.got
    assert (log, lines) == ("", [])
    time = body.pop("time")
    assert datetime.fromisoformat(time) == NOW
    assert body == {"state": "done", "robot": "ada", "sentence": "at the goal"}


def test_a_script_gets_the_words(tmp_path: Path) -> None:
    file = tmp_path / "told"
    script = tmp_path / "tell.sh"
    script.write_text(f'#!/bin/sh\nprintf "%s\\n" "$@" >> {file}\n')
    script.chmod(0o700)

    def look(told: Notifications) -> None:
        told.cycle(robots(lone=DRIVING))
        told.cycle(robots(lone=(State.STOPPED, "stopped by $(id)")))

    section = NotifySection(command=(str(script), "{state}", "{sentence}"))
    assert made_by(section, look) == ("", [])
    assert file.read_text() == "stopped\nstopped by $(id)\n"
