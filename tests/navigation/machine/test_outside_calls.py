"""Calls of programs and web servers: made by another thread, ended in time, and never an error."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

import pytest

from navigation.machine import outside_calls
from navigation.machine.outside_calls import MOST_WAITING, OutsideCall, OutsideCalls
from tests.support.waiting import wait_until

PATIENT_S = 30.0
SHORT_S = 1.0
"""Time limit of calls that hang."""
IGNORED_BY_PYTHON = (signal.SIGPIPE, signal.SIGXFSZ)
"""Signals that a Python process ignores, and a program does not expect to be. Others are ignored by
whoever began the tests: a shell that runs them in the background ignores SIGQUIT."""


class Receiver(HTTPServer):
    """Keeps what it is posted; answers with ``status``."""

    def __init__(self, status: int = 204) -> None:
        super().__init__(("127.0.0.1", 0), _Post)
        self.status = status
        self.got: list[tuple[str, str, Any]] = []

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}/hook/a-key?who=me"


class _Post(BaseHTTPRequestHandler):
    server: Receiver

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["Content-Length"]))
        self.server.got.append((self.path, self.headers["Content-Type"], json.loads(body)))
        self.send_response(self.server.status)
        if self.server.status == 302:
            self.send_header("Location", "http://127.0.0.1:1/elsewhere")
        self.end_headers()

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002 (as above)
        pass


@contextmanager
def receiving(status: int = 204) -> Iterator[Receiver]:
    with Receiver(status) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


def news_of(*calls: OutsideCall, within_s: float = PATIENT_S) -> list[str]:
    """What is said of calls until all are over."""
    with OutsideCalls(within_s) as caller:
        for call in calls:
            caller.put(call)
    return caller.news()


def script(*lines: str) -> tuple[str, ...]:
    return (sys.executable, "-c", "\n".join(("import os, sys, time", *lines)))


def test_a_command_gets_its_arguments_as_they_are(tmp_path: Path) -> None:
    words = ("$HOME `id` ; rm -rf /", "two\nlines", "--flag", "", "ä\N{ROBOT FACE}")
    file = tmp_path / "words.json"
    write = script("import json", f"json.dump(sys.argv[1:], open({str(file)!r}, 'w'))")
    assert news_of(OutsideCall(command=(*write, *words))) == []
    assert json.loads(file.read_text()) == list(words)


def test_a_command_has_the_signals_of_a_fresh_process(tmp_path: Path) -> None:
    file = tmp_path / "ignored"
    assert news_of(OutsideCall(command=("/bin/sh", "-c", f"cat /proc/self/status > {file}"))) == []
    ignored = next(line for line in file.read_text().splitlines() if line.startswith("SigIgn"))
    mask = int(ignored.split()[1], 16)
    assert [one for one in IGNORED_BY_PYTHON if mask >> (one - 1) & 1] == []


def test_a_post_has_its_json_and_its_whole_address() -> None:
    with receiving() as server:
        call = OutsideCall(url=server.url, body='{"sentence": "at the goal \\u00e4"}')
        assert news_of(call) == []
        path, kind, body = server.got[0]
    assert path == "/hook/a-key?who=me"
    assert kind == "application/json"
    assert body == {"sentence": "at the goal ä"}


@pytest.mark.parametrize("status", [302, 404, 500])
def test_a_server_that_refuses_is_said_without_the_key(status: int) -> None:
    with receiving(status) as server:
        (said,) = news_of(OutsideCall(url=server.url, body="{}"))
        assert len(server.got) == 1, "no second try, no redirection"
    assert said.startswith(f"127.0.0.1:{server.server_port}: answered {status}")
    assert "a-key" not in said


def test_a_port_where_no_server_listens_is_said() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # bound, and nothing listens
        port = taken.getsockname()[1]
        (said,) = news_of(OutsideCall(url=f"http://127.0.0.1:{port}/", body="{}"))
    assert said == f"127.0.0.1:{port}: Connection refused"


def test_a_host_that_is_not_known_is_said() -> None:
    (said,) = news_of(OutsideCall(url="http://nowhere.invalid/", body="{}"))
    assert said.startswith("nowhere.invalid: ")


def test_something_else_than_a_web_server_is_said() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            line, _ = server.accept()
            with line:
                line.recv(1000)
                line.sendall(b"220 mail here\r\n")

        thread = threading.Thread(target=answer)
        thread.start()
        port = server.getsockname()[1]
        (said,) = news_of(OutsideCall(url=f"http://127.0.0.1:{port}/", body="{}"))
        thread.join()
    assert said.startswith(f"127.0.0.1:{port}: ")


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (("/nowhere/at-all",), "/nowhere/at-all: exited with 127: there is no such program"),
        (("no-such-program-here",), "no-such-program-here: exited with 127: there is no such"),
        ((str(Path(__file__)),), f"{Path(__file__)}: exited with 127: there is no such program"),
        (("/bin/sh", "-c", "exit 3"), "/bin/sh: exited with 3"),
        (("/bin/sh", "-c", "kill -9 $$"), "/bin/sh: was ended by signal 9"),
        (("/bin/echo", "a\0b"), "/bin/echo: ValueError: embedded null byte"),
    ],
)
def test_a_command_that_fails_is_said(command: tuple[str, ...], said: str) -> None:
    (found,) = news_of(OutsideCall(command=command))
    assert found.startswith(said)


def test_a_command_that_hangs_is_ended_with_all_that_it_has_started(tmp_path: Path) -> None:
    file = tmp_path / "pid"
    hang = f"sleep 600 & echo $! > {file}; sleep 600"
    (said,) = news_of(OutsideCall(command=("/bin/sh", "-c", hang)), within_s=SHORT_S)
    assert said.startswith("/bin/sh: not over within ")
    pid = int(file.read_text())

    def is_gone() -> bool:
        try:
            return "\nState:\tZ" in Path(f"/proc/{pid}/status").read_text()
        except OSError:
            return True

    assert wait_until(is_gone)


def test_a_command_that_writes_without_end_is_not_read(tmp_path: Path) -> None:
    (said,) = news_of(OutsideCall(command=("/usr/bin/yes",)), within_s=SHORT_S)
    assert "not over within" in said


def test_a_server_that_says_nothing_is_left(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        call = OutsideCall(url=f"http://127.0.0.1:{port}/", body="{}")
        (said,) = news_of(call, within_s=SHORT_S)
    assert said.startswith(f"127.0.0.1:{port}: not over within")


def test_who_asks_never_waits_and_what_is_too_much_is_left_out() -> None:
    hang = OutsideCall(command=("/bin/sleep", "600"))
    with OutsideCalls(SHORT_S) as caller:
        for _ in range(MOST_WAITING + 20):
            caller.put(hang)
        said = caller.news()
        assert len(said) >= 19, "one or none is being made"
        assert f"{MOST_WAITING} calls wait already; one is left out" in said[0]
        began_s = time.monotonic()
    # a second for all that wait, then what is killed is waited for: the test's limit is generous
    assert time.monotonic() - began_s < 10.0 * SHORT_S
    assert any("left out: the run is over" in one for one in caller.news())


def test_an_error_of_the_thread_is_said_and_the_next_call_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real, broken = subprocess.Popen, [True]

    def begin(*arguments: Any, **settings: Any) -> Any:
        if broken.pop() if broken else False:
            raise OSError(24, "Too many open files")
        return real(*arguments, **settings)

    monkeypatch.setattr(subprocess, "Popen", begin)
    file = tmp_path / "made"
    touch = OutsideCall(command=("/bin/sh", "-c", f": > {file}"))
    (said,) = news_of(touch, touch)
    assert "Too many open files" in said
    assert file.exists()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # it is left behind
def test_a_process_that_no_signal_ends_does_not_keep_the_thread(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    kept: list[int] = []
    monkeypatch.setattr(outside_calls, "REAPED_WITHIN_S", 0.05)
    monkeypatch.setattr(os, "killpg", lambda pid, _number: kept.append(pid))
    said: list[str] = []
    with OutsideCalls(SHORT_S) as caller:
        caller.put(OutsideCall(command=("/bin/sleep", "600")))
    assert wait_until(lambda: said.extend(caller.news()) or said != [])  # the end waits less
    monkeypatch.undo()
    assert "not over within" in said[0]
    for pid in kept:
        os.killpg(pid, signal.SIGKILL)
