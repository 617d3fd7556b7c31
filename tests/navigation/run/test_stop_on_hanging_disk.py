"""A disk whose sync hangs delays no stop, and answers say what is not on it."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from navigation.config.zones.in_words import as_written
from navigation.control import ControlServer, send_order
from navigation.journal.kept_stops import KeptStops
from navigation.journal.kept_zones import KeptZones
from navigation.link.link_snapshot import doubt_of_stop
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.orders.carry_out import carry_out
from navigation.run.virtual_world import VirtualWorld
from tests.navigation.journal.kept import circle
from tests.support.runs.virtual import cycle_until, is_driving, short_config
from tests.support.waiting import wait_until

ANSWERED_S = 0.3
"""The promise of docs/safety.md."""


class Disk:
    """A disk whose syncs hang until it is ``well``."""

    def __init__(self) -> None:
        self.hangs, self.well = threading.Event(), threading.Event()

    def sync(self, _descriptor: int) -> None:
        self.hangs.set()
        assert self.well.wait(60.0)


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Iterator[Disk]:
    disk = Disk()
    monkeypatch.setattr(os, "fsync", disk.sync)
    yield disk
    disk.well.set()


@pytest.fixture
def driving(tmp_path: Path, disk: Disk) -> Iterator[Daemon]:
    """A robot on its way, whose stops are kept on that disk."""
    config = short_config([{"x_m": 0.9, "y_m": 0.3}])
    with (
        Daemon(config, VirtualWorld(config, pictures=False), first_mission_id=1) as daemon,
        KeptStops(tmp_path / "stops", tmp_path / "c.sock", None, {"": ()}) as stops,
    ):
        daemon.stopping.hold_from_before([daemon.robot], stops)
        daemon.people.give(stations_of(config))
        cycle_until(daemon, is_driving)
        yield daemon
        disk.well.set()


def test_the_robot_is_stopped_while_the_disk_hangs(driving: Daemon, disk: Disk) -> None:
    answer: list[str | None] = []
    person = threading.Thread(target=lambda: answer.append(driving.people.stop("a person")))
    person.start()
    assert disk.hangs.wait(60.0)
    # the disk is asked last: by now the link has the stop, and the mission too
    cycle_until(driving, lambda now: doubt_of_stop(now.link) is None, seconds=5.0)
    assert driving.robot.pilot.mission.state is State.STOPPED
    person.join(60.0)
    assert not disk.well.is_set()
    assert "a restart would not know of this stop" in str(answer[0])
    assert "not on the disk after 0.15 s" in str(answer[0])
    assert "not on the disk" in driving.stopping.trouble  # `clearway status` says it too
    disk.well.set()
    assert wait_until(lambda: driving.stopping.trouble == "")


def test_the_answer_says_what_is_not_known_even_if_the_control_loop_is_late(
    driving: Daemon, disk: Disk, tmp_path: Path
) -> None:
    with ControlServer(tmp_path / "run" / "c.sock", driving.people) as control:
        answer = send_order(control.path, {"order": "stop", "reason": "a person"})
    assert not disk.well.is_set()
    assert answer["ok"]
    assert "a restart would not know of this stop" in answer["trouble"]


def test_orders_behind_a_zone_that_waits_for_the_disk_are_taken(
    driving: Daemon, disk: Disk, tmp_path: Path
) -> None:
    file = tmp_path / "journal.zones"
    driving.zones.restore(KeptZones(file))
    zone = as_written(circle("desk"))
    answers: list[dict[str, Any]] = []

    def orders() -> None:  # one after another, as the socket's thread takes them
        for order in ({"order": "zone_put", "zone": zone}, {"order": "pause"}):
            answers.append(carry_out(order, driving.people))

    person = threading.Thread(target=orders)
    person.start()
    person.join(60.0)
    assert not disk.well.is_set()
    put, paused = answers
    assert "a restart would not know of this change" in put["trouble"]
    assert "not on the disk after 2 s" in put["trouble"]
    assert paused["ok"]
    cycle_until(driving, lambda now: now.mission.paused, seconds=5.0)
    disk.well.set()
    assert wait_until(lambda: driving.zones.trouble == "")
    assert [change.name for change in KeptZones(file).read()] == ["desk"]


@pytest.mark.timed  # says how long a stop takes
def test_a_stop_is_answered_in_time(driving: Daemon, disk: Disk, tmp_path: Path) -> None:
    took_s: list[float] = []
    with ControlServer(tmp_path / "run" / "c.sock", driving.people) as control:

        def order() -> None:
            for _ in range(5):
                began_s = time.monotonic()
                assert send_order(control.path, {"order": "stop"})["ok"]
                took_s.append(time.monotonic() - began_s)

        person = threading.Thread(target=order)
        person.start()
        while person.is_alive():
            driving.cycle()
            time.sleep(0.01)  # the pace of a control loop
    assert not disk.well.is_set()
    assert sorted(took_s)[2] < ANSWERED_S
