"""Orders over the local socket: what is taken, what is refused, and who may."""

import json
import os
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.control import (
    ControlError,
    ControlServer,
    NoDaemonError,
    carry_out,
    default_socket,
    send_order,
)
from navigation.mission.mission import Station
from navigation.orders.table import ORDERS
from tests.support.people import RecordedPeople


@pytest.fixture
def recorder() -> RecordedPeople:
    return RecordedPeople()


@pytest.fixture
def server(tmp_path: Path, recorder: RecordedPeople) -> Iterator[ControlServer]:
    with ControlServer(tmp_path / "run" / "control.sock", recorder) as control:
        yield control


def test_every_order_arrives(server: ControlServer, recorder: RecordedPeople) -> None:
    place = {"x_m": 1.0, "y_m": 2.0, "heading_rad": 0.5, "dwell_s": 2}
    send_order(server.path, {"order": "go", "stations": [place]})
    send_order(server.path, {"order": "stop", "reason": "enough"})
    send_order(server.path, {"order": "pause"})
    send_order(server.path, {"order": "resume"})
    assert send_order(server.path, {"order": "status"})["state"] == "stopped"
    assert recorder.orders == [
        ("give", (Station(1.0, 2.0, 0.5, 2.0),)),
        ("stop", "enough"),
        ("pause",),
        ("resume",),
    ]
    assert recorder.settled == 4


def test_only_the_owner_can_reach_the_socket(server: ControlServer) -> None:
    assert server.path.stat().st_mode & 0o777 == 0o600
    assert server.path.parent.stat().st_mode & 0o077 == 0


def test_a_refused_order_is_told_with_its_reason(
    server: ControlServer, recorder: RecordedPeople
) -> None:
    recorder.refused["give"] = "station 1 at (9, 9) m: outside the arena"
    with pytest.raises(ControlError, match=r"refuses: station 1 at \(9, 9\) m: outside"):
        send_order(server.path, {"order": "go", "stations": [{"x_m": 9, "y_m": 9}]})
    assert server.refused == 1


def test_without_a_daemon_the_error_says_how_to_start_one(tmp_path: Path) -> None:
    with pytest.raises(NoDaemonError, match="clearway run CONFIG"):
        send_order(tmp_path / "nobody.sock", {"order": "status"})


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        ({}, "order None"),
        ({"order": "explode"}, "must be go, stop"),
        ({"order": "go"}, "list of 1 to 1000"),
        ({"order": "go", "stations": []}, "list of 1 to 1000"),
        ({"order": "go", "stations": [[1, 2]]}, "station 1: must be an object"),
        ({"order": "go", "stations": [{"x_m": 1}]}, "y_m = None"),
        ({"order": "go", "stations": [{"x_m": True, "y_m": 1}]}, "x_m = True"),
        ({"order": "go", "stations": [{"x_m": float("inf"), "y_m": 1}]}, "x_m = inf"),
        ({"order": "go", "stations": [{"x_m": 1, "y_m": 1, "dwell_s": -1}]}, "must be >= 0"),
        ({"order": "go", "stations": [{"x_m": 1, "y_m": 1, "speed": 3}]}, "must be an object of"),
    ],
)
def test_a_wrong_request_is_refused_with_what_and_the_limit(
    request_: dict[str, Any], words: str, recorder: RecordedPeople
) -> None:
    answer = carry_out(request_, recorder)
    assert answer["ok"] is False
    assert words in answer["error"]
    assert recorder.orders == []


@pytest.mark.parametrize("reason", [3, None, {"a": []}, ["now"], float("nan")])
def test_a_stop_is_taken_whatever_stands_in_place_of_its_reason(
    reason: Any, recorder: RecordedPeople
) -> None:
    assert carry_out({"order": "stop", "reason": reason}, recorder)["ok"]
    assert recorder.orders == [("stop", "stopped by order")]


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text() | st.sampled_from(list(ORDERS)),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=6,
)


@given(st.dictionaries(st.sampled_from(["order", "stations", "reason"]), ANYTHING))
def test_no_request_raises(request_: dict[str, Any]) -> None:
    assert carry_out(request_, RecordedPeople())["ok"] in (True, False)


@pytest.mark.parametrize("data", [b"\n", b"not json\n", b"[1]\n", b"\xff\xfe\n", b"x" * 70_000])
def test_garbage_on_the_socket_is_refused_and_the_server_lives(
    server: ControlServer, data: bytes
) -> None:
    with socket.socket(socket.AF_UNIX) as client:
        client.settimeout(5.0)
        client.connect(str(server.path))
        client.sendall(data)
        client.shutdown(socket.SHUT_WR)
        try:
            answer = client.recv(4096)
        except ConnectionResetError:
            answer = b""
    assert not answer or json.loads(answer)["ok"] is False
    assert server.refused == 1
    assert send_order(server.path, {"order": "status"})["ok"]
    assert send_order(server.path, {"order": "status"})["schema"] == "clearway.status/1"


def test_a_second_daemon_on_one_socket_is_refused(server: ControlServer) -> None:
    with (
        pytest.raises(ControlError, match="another daemon listens"),
        ControlServer(server.path, RecordedPeople()),
    ):
        pass
    assert send_order(server.path, {"order": "status"})["ok"]


def test_a_leftover_socket_is_replaced_and_a_file_never(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    folder.mkdir(mode=0o700)
    path = folder / "control.sock"
    with socket.socket(socket.AF_UNIX) as dead:
        dead.bind(str(path))
    with ControlServer(path, RecordedPeople()):
        assert send_order(path, {"order": "status"})["ok"]
    assert not path.exists()
    path.write_text("precious")
    with pytest.raises(ControlError, match="is a file"), ControlServer(path, RecordedPeople()):
        pass
    assert path.read_text() == "precious"


def test_a_folder_that_others_can_write_to_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "open"
    folder.mkdir()
    folder.chmod(0o777)
    with (
        pytest.raises(ControlError, match="yours alone"),
        ControlServer(folder / "c", RecordedPeople()),
    ):
        pass


def test_a_link_of_ones_own_to_a_private_folder_is_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """systemd makes /run/clearway such a link where it makes up the account (DynamicUser)."""
    private, link = tmp_path / "private", tmp_path / "clearway"
    private.mkdir(mode=0o700)
    link.symlink_to(private)
    with ControlServer(link / "socket", RecordedPeople()):
        assert (private / "socket").is_socket()

    private.chmod(0o777)
    with pytest.raises(ControlError, match="must be yours alone"):
        ControlServer(link / "socket", RecordedPeople()).__enter__()
    private.chmod(0o700)

    lstat = Path.lstat

    def of_a_stranger(path: Path) -> os.stat_result:
        info = lstat(path)
        return os.stat_result((*info[:4], os.getuid() + 1, *info[5:])) if path == link else info

    monkeypatch.setattr(Path, "lstat", of_a_stranger)
    with pytest.raises(ControlError, match="must be yours alone"):
        ControlServer(link / "socket", RecordedPeople()).__enter__()


def test_the_default_socket_follows_the_runtime_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("RUNTIME_DIRECTORY", raising=False)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    assert default_socket() == tmp_path / "clearway" / "control.sock"
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    assert default_socket().name == "control.sock"
