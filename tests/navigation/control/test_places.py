"""A daemon whose socket is removed, replaced or forged is found, by its own user and root only."""

import os
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from navigation.control import (
    ControlError,
    ControlServer,
    NoDaemonError,
    ask,
    peers,
    send_order,
)
from navigation.control.abstract import Abstract, all_listening, digest_of, listen_without_a_file
from navigation.control.peers import Peer
from tests.support.people import RecordedPeople
from tests.support.waiting import wait_until

BACK_WITHIN_S = 1.0


@pytest.fixture
def robot() -> RecordedPeople:
    return RecordedPeople()


@pytest.fixture
def server(tmp_path: Path, robot: RecordedPeople) -> Iterator[ControlServer]:
    with ControlServer(tmp_path / "run" / "c.sock", robot) as control:
        yield control


@pytest.fixture
def only(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """On this computer run only the daemons of these paths."""

    def show(*paths: Path) -> None:
        digests = {digest_of(path) for path in paths}

        def some() -> list[Abstract]:
            return [one for one in all_listening() if one.digest in digests]

        monkeypatch.setattr(ask, "all_listening", some)

    return show


def stop_is_taken(path: Path | None, robot: RecordedPeople) -> bool:
    before = len(robot.orders)
    answer = send_order(path, {"order": "stop"})
    return answer["state"] in ("stopped", "stopping") and len(robot.orders) > before


@pytest.mark.parametrize("what", ["file", "folder"])
def test_a_stop_is_taken_at_once_when_the_file_or_its_folder_is_gone(
    what: str, server: ControlServer, robot: RecordedPeople
) -> None:
    if what == "file":
        server.path.unlink()
    else:
        shutil.rmtree(server.path.parent)
    assert stop_is_taken(server.path, robot)
    assert wait_until(server.path.is_socket, BACK_WITHIN_S)
    assert server.path.parent.stat().st_mode & 0o777 == 0o700
    assert stop_is_taken(server.path, robot)
    assert wait_until(lambda: any("made again" in one for one in server.news()))
    assert server.trouble == ""


def test_a_daemon_whose_file_is_gone_is_found_by_another_spelling_of_its_path(
    server: ControlServer, robot: RecordedPeople, tmp_path: Path
) -> None:
    (tmp_path / "alias").symlink_to(server.path.parent)
    server.path.unlink()
    assert stop_is_taken(tmp_path / "alias" / ".." / "run" / server.path.name, robot)


def test_where_the_file_cannot_be_made_again_another_stands_in_until_it_can(
    server: ControlServer, robot: RecordedPeople, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand_in = tmp_path / "tmp"
    stand_in.mkdir(mode=0o700)
    monkeypatch.setattr(tempfile, "tempdir", str(stand_in))
    shutil.rmtree(server.path.parent)
    server.path.parent.write_text("in its place")
    assert wait_until(lambda: server.trouble != "", BACK_WITHIN_S)
    assert "cannot be made: " in server.trouble
    there = Path(server.trouble.rpartition("orders work at ")[2])
    assert there.is_relative_to(stand_in)
    assert stop_is_taken(there, robot), "at the place that is said"
    assert stop_is_taken(server.path, robot), "by the path that was configured"
    server.path.parent.unlink()
    assert wait_until(lambda: server.trouble == "", BACK_WITHIN_S)
    assert server.path.is_socket()
    assert not there.exists()
    assert stop_is_taken(server.path, robot)


def test_where_no_file_can_be_made_at_all_a_stop_is_still_taken(
    server: ControlServer, robot: RecordedPeople, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere" / "at" / "all"))
    (tmp_path / "nowhere").write_text("no folder")
    shutil.rmtree(server.path.parent)
    server.path.parent.write_text("in its place")
    assert wait_until(lambda: "without --socket only" in server.trouble, BACK_WITHIN_S)
    assert stop_is_taken(server.path, robot)
    assert server.failure() is None


def test_another_daemon_that_took_the_removed_file_keeps_it(
    server: ControlServer, robot: RecordedPeople, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    server.path.unlink()
    with socket.socket(socket.AF_UNIX) as other:
        other.bind(str(server.path))
        other.listen()
        taken = server.path.lstat().st_ino
        assert wait_until(lambda: "another daemon listens" in server.trouble, BACK_WITHIN_S)
        assert server.path.lstat().st_ino == taken
    assert server.failure() is None


@pytest.mark.timed  # says how long a daemon that hangs delays a stop of the others
def test_without_a_path_a_stop_stops_every_daemon_and_other_orders_want_one_named(
    tmp_path: Path, only: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ask, "default_socket", lambda: tmp_path / "nobody.sock")
    paths = [tmp_path / name / "c.sock" for name in ("one", "two")]
    robots = [RecordedPeople(), RecordedPeople()]
    only(*paths)
    with ControlServer(paths[0], robots[0]), ControlServer(paths[1], robots[1]):
        with pytest.raises(ControlError, match=f"2 daemons run.*{paths[0]}, {paths[1]}"):
            send_order(None, {"order": "pause"})
        assert robots[0].orders == robots[1].orders == []
        answer = send_order(None, {"order": "stop"})
        assert {one["socket"] for one in answer["daemons"]} == set(map(str, paths))
        assert answer["state"] == "stopped"
        assert all(one.orders == [("stop", "stopped by order")] for one in robots)
        robots[1].hanging = {"settle"}
        began_s = time.monotonic()
        assert send_order(None, {"order": "stop"})["state"] == "stopping"
        assert time.monotonic() - began_s < 1.0
        robots[1].free.set()
    with pytest.raises(NoDaemonError):
        send_order(None, {"order": "stop"})


def test_without_a_path_the_only_daemon_takes_every_order(
    server: ControlServer,
    robot: RecordedPeople,
    tmp_path: Path,
    only: Callable[..., None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(ask, "default_socket", lambda: tmp_path / "nobody.sock")
    only(server.path)
    assert send_order(None, {"order": "pause"})["socket"] == str(server.path)
    assert robot.orders == [("pause",)]


def test_a_path_that_is_given_reaches_no_other_daemon(
    server: ControlServer, robot: RecordedPeople, tmp_path: Path
) -> None:
    with pytest.raises(NoDaemonError):
        send_order(tmp_path / "other.sock", {"order": "stop"})
    assert robot.orders == []


# Strangers.


@pytest.fixture
def a_user(monkeypatch: pytest.MonkeyPatch) -> None:
    """This process is not root, whoever runs the test."""
    monkeypatch.setattr(os, "geteuid", lambda: 1000)


@pytest.mark.usefixtures("a_user")
def test_another_user_is_not_served_and_takes_nobodys_place(
    server: ControlServer, robot: RecordedPeople, monkeypatch: pytest.MonkeyPatch
) -> None:
    import navigation.control.server as module

    monkeypatch.setattr(module, "peer_of", lambda _: Peer(1, 4242))
    [ours] = [one for one in all_listening() if one.digest == digest_of(server.path)]
    for address in (ours.address, str(server.path)):
        with socket.socket(socket.AF_UNIX) as client:
            client.settimeout(2.0)
            client.connect(address)
            try:
                client.sendall(b'{"order": "stop"}\n')
                assert client.recv(100) == b""
            except ConnectionError:
                pass
    assert robot.orders == []
    monkeypatch.undo()
    assert stop_is_taken(server.path, robot)


@pytest.mark.usefixtures("a_user")
@pytest.mark.parametrize("where", ["file", "name"])
def test_another_user_who_took_the_file_or_a_name_does_not_answer_for_the_daemon(
    where: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import navigation.control.exchange as module

    path = tmp_path / "c.sock"
    monkeypatch.setattr(module, "peer_of", lambda _: Peer(1, 4242))
    with (
        socket.socket(socket.AF_UNIX) if where == "file" else listen_without_a_file(path, 5)
    ) as squatter:
        if where == "file":
            squatter.bind(str(path))
            squatter.listen()
        with pytest.raises(NoDaemonError):
            send_order(path, {"order": "stop"})


def test_names_taken_beforehand_keep_no_daemon_from_its_start(
    tmp_path: Path, robot: RecordedPeople
) -> None:
    path = tmp_path / "run" / "c.sock"
    with listen_without_a_file(path, 5), ControlServer(path, robot):
        assert stop_is_taken(path, robot)


def test_a_process_that_listens_and_does_not_answer_is_not_said_to_be_no_daemon(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ask, "PATIENCE_S", 0.2)
    path = tmp_path / "c.sock"
    with listen_without_a_file(path, 0):
        for _ in range(2):  # the second finds its queue full
            with pytest.raises(ControlError, match="does not answer") as refused:
                send_order(path, {"order": "stop"})
            assert not isinstance(refused.value, NoDaemonError)


def test_where_sockets_cannot_be_listed_nobody_is_not_said_to_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail() -> list[Abstract]:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(ask, "all_listening", fail)
    with pytest.raises(ControlError, match="it is unknown if a daemon runs") as refused:
        send_order(tmp_path / "c.sock", {"order": "stop"})
    assert not isinstance(refused.value, NoDaemonError)


def test_a_peer_has_ended_only_where_its_process_has() -> None:
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        assert process.wait(10.0) == 0
    assert Peer(process.pid, 0).has_ended
    assert not Peer(os.getpid(), 0).has_ended
    assert not Peer(0, 0).has_ended, "it is in a namespace that is not seen here"
    ours, theirs = socket.socketpair()
    with ours, theirs:
        assert peers.peer_of(ours) == Peer(os.getpid(), os.geteuid())


@pytest.mark.parametrize("theirs", ["c.sock", "d.sock"])
def test_of_two_programs_that_begin_at_once_none_takes_the_others_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, theirs: str
) -> None:
    """One found a leftover dead, the other replaced it meanwhile: no order would reach that one.

    With another path in the same folder both listen.
    """
    path = tmp_path / "folder" / "c.sock"
    path.parent.mkdir(mode=0o700)
    with socket.socket(socket.AF_UNIX) as leftover:
        leftover.bind(str(path))
    said: list[str] = []

    def begin() -> None:
        try:
            with ControlServer(path.with_name(theirs), RecordedPeople()):
                said.append("listens")
        except ControlError as error:
            said.append(str(error))

    unlink, other = Path.unlink, threading.Thread(target=begin)

    def late_unlink(file: Path) -> None:
        monkeypatch.setattr(Path, "unlink", unlink)
        other.start()
        other.join(0.5)
        unlink(file)

    monkeypatch.setattr(Path, "unlink", late_unlink)
    with ControlServer(path, RecordedPeople()):
        other.join(10.0)
    (sentence,) = said
    assert sentence == "listens" if theirs == "d.sock" else "listens there already" in sentence
