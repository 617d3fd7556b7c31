"""Hostile clients of the control socket: whatever they send or keep back, a stop is taken."""

from __future__ import annotations

import contextlib
import json
import socket
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from navigation.control import ControlError, ControlServer, carry_out, send_order
from navigation.control.clients import (
    ANSWER_WITHIN_S,
    MOST_CLIENTS,
    REQUEST_WITHIN_S,
    Client,
    who_makes_room,
)
from navigation.control.order_thread import Job
from navigation.control.server import STUCK_S
from navigation.orders.table import ORDERS
from tests.support.people import RecordedPeople
from tests.support.processes.floods import flood
from tests.support.waiting import wait_until

STOPPED_WITHIN_S = 0.3
A_PLACE = {"x_m": 1.0, "y_m": 1.0}


class Clock:
    """Seconds that pass when a test says so."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def robot() -> Iterator[RecordedPeople]:
    robot = RecordedPeople()
    yield robot
    robot.free.set()


@pytest.fixture
def server(tmp_path: Path, robot: RecordedPeople) -> Iterator[ControlServer]:
    with ControlServer(tmp_path / "run" / "control.sock", robot) as control:
        yield control


@contextlib.contextmanager
def connected(path: Path) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX) as client:
        client.settimeout(5.0)
        client.connect(str(path))
        yield client


def tell(path: Path, data: bytes) -> bytes:
    """What the server answers to these bytes; empty where it hung up on them."""
    with connected(path) as client:
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            client.sendall(data)
            client.shutdown(socket.SHUT_WR)
        try:
            return client.recv(65_536)
        except ConnectionResetError:
            return b""


def assert_a_stop_is_taken(server: ControlServer, robot: RecordedPeople) -> None:
    answer = send_order(server.path, {"order": "stop"})
    assert answer["state"] in ("stopped", "stopping")
    assert robot.orders[-1] == ("stop", "stopped by order")
    assert server.failure() is None


# What they send.


HOSTILE = {
    "a number of 400 digits": b'{"order": "go", "stations": [{"x_m": 1%s, "y_m": 1}]}'
    % (b"0" * 400),
    "a number of 5000 digits": b'{"order": "go", "stations": [{"x_m": 1%s}]}' % (b"0" * 5000),
    "an order of 4000 digits": b'{"order": 1%s}' % (b"0" * 4000),
    "deep lists": b"[" * 60_000,
    "deep objects": b'{"a":' * 10_000,
    "a deep order": b'{"order": %s%s}' % (b"[" * 900, b"]" * 900),
    "half a pair": b'{"order": "\\ud800"}',
    "half a pair as a key": b'{"order": "go", "stations": [{"\\udfff": 1}]}',
    "no number": b'{"order": "go", "stations": [{"x_m": NaN, "y_m": -Infinity}]}',
    "an endless stay": b'{"order": "go", "stations": [{"x_m": 1, "y_m": 1, "dwell_s": 1e308}]}',
    "zero bytes": b"\0" * 1000,
    "UTF-16": '{"order": "go"}'.encode("utf-16"),
    "no UTF-8": b'{"order": "\xff\xfe"}',
}


@pytest.mark.parametrize("name", HOSTILE)
def test_no_line_ends_the_thread(name: str, server: ControlServer, robot: RecordedPeople) -> None:
    answer = json.loads(tell(server.path, HOSTILE[name] + b"\n"))
    assert answer["ok"] is False
    assert answer["error"].isprintable()
    assert len(answer["error"]) < 200
    assert robot.orders == []
    assert_a_stop_is_taken(server, robot)


@pytest.fixture(scope="module")
def fuzzed(
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[tuple[ControlServer, RecordedPeople]]:
    robot = RecordedPeople()
    path = tmp_path_factory.mktemp("run") / "control.sock"
    path.parent.chmod(0o700)
    with ControlServer(path, robot) as server:
        yield server, robot


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(st.characters(codec=None)),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=12,
)
STATION = st.fixed_dictionaries(
    {}, optional=dict.fromkeys(("x_m", "y_m", "heading_rad", "dwell_s"), JSON)
)
ORDER = st.sampled_from(list(ORDERS)) | JSON
REQUEST = st.fixed_dictionaries(
    {}, optional={"order": ORDER, "stations": st.lists(STATION, max_size=3) | JSON, "reason": JSON}
)


@given(REQUEST)
def test_no_request_raises_and_every_answer_can_be_sent(request_: dict[str, Any]) -> None:
    robot = RecordedPeople()
    answer = carry_out(request_, robot)
    assert answer["ok"] in (True, False)
    json.dumps(answer).encode()
    assert answer.get("error", "").encode().decode().isprintable()
    for order in robot.orders:
        if order[0] == "stop":
            assert order[1].isprintable()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(data=st.binary(max_size=300) | JSON.map(lambda one: json.dumps(one).encode()))
def test_no_bytes_end_the_thread(data: bytes, fuzzed: tuple[ControlServer, RecordedPeople]) -> None:
    server, _robot = fuzzed
    answer = tell(server.path, data)
    assert not answer or json.loads(answer)["ok"] in (True, False)
    assert server.failure() is None
    assert send_order(server.path, {"order": "status"})["ok"]


def test_a_reason_of_any_bytes_is_taken_and_is_printable_then(
    server: ControlServer, robot: RecordedPeople
) -> None:
    reason = b"\xff\x00\x1b[2Jquick\n".decode(errors="surrogateescape") + "!" * 5000
    assert send_order(server.path, {"order": "stop", "reason": reason})["ok"]
    ((_, said),) = robot.orders
    assert "quick" in said
    assert said.isprintable()
    assert len(said) == 500


def test_an_order_that_fails_in_the_program_is_answered_and_the_next_is_taken(
    server: ControlServer, robot: RecordedPeople, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_robot: str | None) -> None:
        raise ZeroDivisionError("a test")

    monkeypatch.setattr(robot, "pause", fail)
    with pytest.raises(ControlError, match="ZeroDivisionError: a test"):
        send_order(server.path, {"order": "pause"})
    assert_a_stop_is_taken(server, robot)


@pytest.mark.timed  # says how long a stop takes
def test_a_stop_passes_hundreds_of_clients_that_drip(
    server: ControlServer, robot: RecordedPeople
) -> None:
    with flood("unix", str(server.path), 300):
        assert wait_until(lambda: server.refused > 300), "they are dropped and come again"
        took_s = []
        for _ in range(11):
            began_s = time.monotonic()
            assert send_order(server.path, {"order": "stop"})["ok"]
            took_s.append(time.monotonic() - began_s)
        assert statistics.median(took_s) < STOPPED_WITHIN_S
        assert len(server._clients) <= MOST_CLIENTS
    assert server.failure() is None
    assert robot.orders == [("stop", "stopped by order")] * 11


def test_a_request_has_its_time_as_a_whole(tmp_path: Path, robot: RecordedPeople) -> None:
    clock = Clock()
    with (
        ControlServer(tmp_path / "run" / "c.sock", robot, clock=clock) as server,
        connected(server.path) as client,
    ):
        assert wait_until(lambda: len(server._clients) == 1)
        for quarter in range(4):
            client.sendall(b" ")
            clock.now_s = quarter * REQUEST_WITHIN_S / 4.0
        clock.now_s = REQUEST_WITHIN_S + 0.01
        assert "no request came within 2 s" in json.loads(client.recv(1000))["error"]
        assert wait_until(lambda: server.refused == 1)


def test_an_order_that_hangs_holds_up_no_stop_and_is_given_up(
    tmp_path: Path, robot: RecordedPeople
) -> None:
    clock = Clock()
    robot.hanging = {"pause"}
    with (
        ControlServer(tmp_path / "run" / "c.sock", robot, clock=clock) as server,
        connected(server.path) as client,
    ):
        client.sendall(b'{"order": "pause"}\n')
        assert robot.entered.wait(5.0)
        assert_a_stop_is_taken(server, robot)
        assert robot.orders == [("stop", "stopped by order")]
        turns = server.turns
        assert wait_until(lambda: server.turns > turns + 2), "it is not stuck yet"
        clock.now_s = max(STUCK_S, ANSWER_WITHIN_S) + 0.1
        assert "has not answered" in json.loads(client.recv(1000))["error"]
        turns = server.turns
        assert not wait_until(lambda: server.turns > turns + 1, 1.0), "the watchdog must see it"
        robot.free.set()
        assert wait_until(lambda: server.turns > turns + 2)


def test_a_stop_is_answered_in_time_where_the_control_loop_does_not_act(
    server: ControlServer, robot: RecordedPeople
) -> None:
    robot.hanging = {"settle"}
    began_s = time.monotonic()
    answer = send_order(server.path, {"order": "stop"})
    assert time.monotonic() - began_s < STOPPED_WITHIN_S
    assert answer["state"] == "stopping"
    assert "has not confirmed" in answer["reason"]


def test_the_oldest_that_said_nothing_makes_room_and_a_stop_last_of_all() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        silent = [Client(ours, came_s) for came_s in (3.0, 1.0, 2.0)]
        going = Client(ours, 0.0, Job({"order": "go"}, 0.0))
        stopping = Client(ours, -1.0, Job({"order": "stop"}, 0.0))
        everybody = [stopping, going, *silent]
        left = []
        while everybody:
            left.append(who_makes_room(everybody))
            everybody.remove(left[-1])
        assert left == [silent[1], silent[2], silent[0], going, stopping]


@pytest.mark.parametrize(
    "first", [b"", b'{"ok": false, "error": "crowded", "again": true}\n'], ids=["mute", "crowded"]
)
def test_a_stop_that_found_no_place_is_asked_for_again_and_a_go_is_not(
    first: bytes, tmp_path: Path
) -> None:
    path, asked = tmp_path / "c.sock", []

    def serve(listening: socket.socket) -> None:
        for answer in (first, first, b'{"ok": true, "state": "stopped", "reason": ""}\n'):
            connection, _ = listening.accept()
            with connection:
                asked.append(json.loads(connection.recv(1000))["order"])
                connection.sendall(answer)

    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(path))
        listening.listen()
        thread = threading.Thread(target=serve, args=(listening,))
        thread.start()
        with pytest.raises(ControlError, match="does not answer"):
            send_order(path, {"order": "go", "stations": [A_PLACE]})
        assert send_order(path, {"order": "stop"})["state"] == "stopped"
        thread.join(10.0)
    assert asked == ["go", "stop", "stop"]


# Descriptors, and the thread's own life.


WITHOUT_DESCRIPTORS = """
import os, resource, sys
from pathlib import Path
from navigation.control import ControlServer
from tests.support.people import RecordedPeople
resource.setrlimit(resource.RLIMIT_NOFILE, (128, 128))
with ControlServer(Path(sys.argv[1]), RecordedPeople()):
    try:
        while True:
            os.open(os.devnull, os.O_RDONLY)
    except OSError:
        print("none left", flush=True)
    sys.stdin.read()
"""


@pytest.mark.timed  # says how long a stop takes
def test_a_stop_arrives_where_no_descriptor_is_left(tmp_path: Path) -> None:
    path = tmp_path / "run" / "c.sock"
    with subprocess.Popen(
        [sys.executable, "-c", WITHOUT_DESCRIPTORS, str(path)],
        cwd=Path(__file__).parents[3],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stdin is not None
        assert process.stdout.readline() == "none left\n"
        with contextlib.ExitStack() as silent:
            for _ in range(20):  # more than are held back
                silent.enter_context(connected(path))
            for _ in range(20):
                began_s = time.monotonic()
                assert send_order(path, {"order": "stop"})["state"] == "stopped"
                assert time.monotonic() - began_s < STOPPED_WITHIN_S
        path.unlink()
        assert send_order(path, {"order": "stop"})["state"] == "stopped"
        assert wait_until(path.is_socket, 2.0), "made again with a descriptor that was held back"
        process.stdin.close()
        assert process.wait(10.0) == 0


def test_a_thread_that_ended_is_said_and_started_again(
    server: ControlServer, robot: RecordedPeople, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("a test")

    monkeypatch.setattr(server, "_look_after", fail)
    with pytest.raises(ControlError):
        send_order(server.path, {"order": "status"})
    assert wait_until(lambda: server.failure() is not None)
    assert server.failure() == "ZeroDivisionError: a test"
    turns = server.turns
    monkeypatch.undo()
    server.restart()
    assert wait_until(lambda: server.turns > turns)
    assert_a_stop_is_taken(server, robot)


def test_a_client_that_does_not_wait_harms_nobody(
    server: ControlServer, robot: RecordedPeople
) -> None:
    for _ in range(50):
        with connected(server.path) as client:
            client.sendall(b'{"order": "status"}\n')
        with connected(server.path):
            pass
    assert_a_stop_is_taken(server, robot)
