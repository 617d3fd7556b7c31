"""Messages to systemd, and their times: the state, and that every stage turns."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from navigation.machine.sd_notify import Notifier, Watchdog, watchdog_period_s
from tests.support.processes.systemd import messages_to


def test_a_message_is_one_datagram_of_assignments(
    notifier: Notifier, systemd: socket.socket
) -> None:
    assert notifier.send("READY=1", "STATUS=driving")
    assert systemd.recv(4096) == b"READY=1\nSTATUS=driving"


def test_without_systemd_nothing_is_sent_and_nothing_fails() -> None:
    notifier = Notifier.from_environment({})
    assert notifier.send("READY=1")
    assert notifier.lost == 0


def test_a_socket_in_the_abstract_namespace_is_reached() -> None:
    name = f"clearway-test-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as end:
        end.bind("\0" + name)
        end.settimeout(5.0)
        notifier = Notifier(f"@{name}")
        assert notifier.send("READY=1")
        notifier.close()
        assert end.recv(64) == b"READY=1"


def test_a_full_socket_loses_messages_and_never_waits(
    notifier: Notifier, systemd: socket.socket
) -> None:
    sent = [notifier.send("STATUS=" + "x" * 1000) for _ in range(2000)]
    assert sent[0]
    assert not sent[-1]
    assert notifier.lost == sent.count(False)


def test_a_systemd_that_is_gone_costs_messages_only(tmp_path: Path) -> None:
    notifier = Notifier(str(tmp_path / "nobody"))
    assert not notifier.send("READY=1")
    notifier.close()


def test_what_came_from_outside_sets_nothing_else(
    notifier: Notifier, systemd: socket.socket
) -> None:
    assert notifier.send("STATUS=stopped: \udcff quick\nWATCHDOG=trigger", "READY=1")
    assert systemd.recv(4096).decode().split("\n")[1:] == ["READY=1"]


# The watchdog.


class Stages:
    """Counters that a test lets turn."""

    def __init__(self) -> None:
        self.turns = {"camera": 0, "planner": 0, "link": 0}

    def turn(self, *names: str) -> None:
        for name in names or self.turns:
            self.turns[name] += 1


def test_the_watchdog_is_fed_four_times_a_period_while_every_stage_turns(
    notifier: Notifier, systemd: socket.socket
) -> None:
    stages = Stages()
    watchdog = Watchdog(notifier, 8.0, lambda: stages.turns)
    lines = []
    for quarter in range(4 * 40 + 1):
        stages.turn()
        watchdog.tick(quarter / 4.0)
        lines += messages_to(systemd)
    assert lines == ["WATCHDOG=1"] * 20
    assert watchdog.hanging == ()


@pytest.mark.parametrize("stuck", ["camera", "planner", "link"])
def test_one_stage_that_hangs_is_enough_and_is_named(
    notifier: Notifier, systemd: socket.socket, stuck: str
) -> None:
    stages = Stages()
    watchdog = Watchdog(notifier, 8.0, lambda: stages.turns)
    others = [name for name in stages.turns if name != stuck]
    for tenth in range(200):
        stages.turn(*others)
        watchdog.tick(tenth / 10.0)
    assert messages_to(systemd) == [f"STATUS=does not get on: {stuck}"]
    assert watchdog.hanging == (stuck,)
    stages.turn()
    watchdog.tick(30.0)
    assert messages_to(systemd) == ["WATCHDOG=1"]
    assert watchdog.hanging == ()


def test_a_stage_that_is_slow_once_is_not_called_hanging(
    notifier: Notifier, systemd: socket.socket
) -> None:
    stages = Stages()
    watchdog = Watchdog(notifier, 8.0, lambda: stages.turns)
    for tenth in range(35):
        stages.turn("camera", "link")
        watchdog.tick(tenth / 10.0)
    stages.turn()
    watchdog.tick(3.5)
    assert messages_to(systemd) == ["WATCHDOG=1"]


def test_no_watchdog_without_a_period(notifier: Notifier, systemd: socket.socket) -> None:
    watchdog = Watchdog(notifier, None, lambda: {"camera": 0})
    watchdog.tick(1e9)
    assert messages_to(systemd) == []


@pytest.mark.parametrize(
    ("environment", "period_s"),
    [
        ({"WATCHDOG_USEC": "40000000"}, 40.0),
        ({"WATCHDOG_USEC": "40000000", "WATCHDOG_PID": "7"}, 40.0),
        ({"WATCHDOG_USEC": "40000000", "WATCHDOG_PID": "8"}, None),
        ({"WATCHDOG_USEC": "soon"}, None),
        ({"WATCHDOG_USEC": "0"}, None),
        ({}, None),
    ],
)
def test_the_period_is_systemd_s_for_this_process(
    environment: dict[str, str], period_s: float | None
) -> None:
    assert watchdog_period_s(environment, own_pid=7) == period_s
