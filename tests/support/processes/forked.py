"""`clearway`, or a Python file, as a process forked from one that has all modules and kernels.

Loading them is most of a start's processor time. A `Program` is a process of its own all the same:
with its arguments, folder, environment, outputs, signals and exit code. What tests a start itself
starts the real one.

The process that forks begins with the first program and ends with the tests.
"""

from __future__ import annotations

import atexit
import gc
import json
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import cache
from pathlib import Path
from threading import Thread
from types import TracebackType
from typing import IO, Any, Final

CONFIG: Final = Path(__file__).parents[3] / "configs" / "simulation.yaml"
ONE_THREAD: Final = {"OPENBLAS_NUM_THREADS": "1", "OPENCV_FOR_THREADS_NUM": "1"}
"""A fork has none of the threads that a library has begun, and would wait for them for ever."""
LONGEST: Final = 1 << 18
"""Longest request, bytes."""

_spent_s: list[float] = []


def spent_s() -> float:
    """Processor time of all programs that have ended, and of getting ready to fork them.

    They are no children of this process, whose own times lack them.
    """
    return sum(_spent_s)


class Program:
    """``clearway ARGUMENTS``, or ``python FILE ARGUMENTS``.

    The other parameters, and the members, are those of ``subprocess.Popen`` for text.
    """

    def __init__(
        self,
        arguments: Sequence[object],
        *,
        file: Path | None = None,
        cwd: Path | None = None,
        env: Mapping[str, str] | None = None,
        stdin: int = subprocess.DEVNULL,
        stdout: int | IO[Any] | None = None,
        stderr: int | IO[Any] | None = None,
    ) -> None:
        asked = {
            "words": [str(one) for one in (file or "clearway", *arguments)],
            "is_file": file is not None,
            "cwd": str(cwd or Path.cwd()),
            "environment": dict(os.environ if env is None else env),
        }
        self.returncode: int | None = None
        with ExitStack() as given:
            out, self.stdout = _output(stdout, 1, given)
            err, self.stderr = _output(stderr, out if stderr == subprocess.STDOUT else 2, given)
            if stdin == subprocess.DEVNULL:
                stdin = given.enter_context(open(os.devnull)).fileno()
            self._news, told = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            given.callback(told.close)
            descriptors = [told.fileno(), stdin, out, err]
            socket.send_fds(_server(), [json.dumps(asked).encode()], descriptors)
        self.pid = int(self._hear()["pid"])

    def __enter__(self) -> Program:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for stream in self._streams():
            stream.close()
        self.wait()

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its end; return the exit code, or minus the signal that ended it."""
        if self.returncode is None:
            if not select.select([self._news], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired("clearway", timeout or 0.0)
            ended = self._hear()
            self.returncode = int(ended["code"])
            _spent_s.append(ended["spent_s"])
            self._news.close()
        return self.returncode

    def poll(self) -> int | None:
        """Its exit code; None while it runs."""
        with suppress(subprocess.TimeoutExpired):
            self.wait(0.0)
        return self.returncode

    def communicate(self, timeout: float | None = None) -> tuple[str, str]:
        """Read both outputs to their ends, and wait."""
        until_s = None if timeout is None else time.monotonic() + timeout
        said = {1: "", 2: ""}

        def read(number: int, stream: IO[str]) -> None:
            said[number] = stream.read()

        named = ((1, self.stdout), (2, self.stderr))
        readers = [Thread(target=read, args=one, daemon=True) for one in named if one[1]]
        for reader in readers:
            reader.start()
        for reader in readers:
            reader.join(None if until_s is None else max(0.0, until_s - time.monotonic()))
        self.wait(None if until_s is None else max(0.0, until_s - time.monotonic()))
        for stream in self._streams():
            stream.close()
        return said[1], said[2]

    def send_signal(self, number: int) -> None:
        """Send it a signal, if it runs."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def terminate(self) -> None:
        """Ask it to end."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """End it."""
        self.send_signal(signal.SIGKILL)

    def _streams(self) -> list[IO[str]]:
        return [one for one in (self.stdout, self.stderr) if one is not None]

    def _hear(self) -> dict[str, Any]:
        data = self._news.recv(LONGEST)
        assert data, "the process that forks has ended"
        return dict(json.loads(data))


def _output(
    asked: int | IO[Any] | None, usual: int, given: ExitStack
) -> tuple[int, IO[str] | None]:
    """Descriptor for the program, and this end of its pipe."""
    if asked is None or asked == subprocess.STDOUT:
        return usual, None
    if asked == subprocess.PIPE:
        ours, theirs = os.pipe()
        given.callback(os.close, theirs)
        return theirs, os.fdopen(ours)
    if asked == subprocess.DEVNULL:
        return given.enter_context(open(os.devnull, "w")).fileno(), None
    assert not isinstance(asked, int)
    return asked.fileno(), None


@cache
def _server() -> socket.socket:
    """The line to the process that forks, once that has loaded everything."""
    here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with there:
        command = [sys.executable, "-m", __name__, str(there.fileno())]
        folder = Path(__file__).parents[3]
        process = subprocess.Popen(
            command,
            cwd=folder,
            env={**os.environ, **ONE_THREAD},
            pass_fds=[there.fileno()],
            stdin=subprocess.DEVNULL,
        )
    atexit.register(_end, process, here)
    ready = here.recv(LONGEST)
    assert ready, f"the process that forks has ended: {process.wait()}"
    _spent_s.append(float(ready))
    return here


def _end(process: subprocess.Popen[bytes], line: socket.socket) -> None:
    line.close()
    process.wait()


def _serve(line: socket.socket) -> dict[str, Any] | None:
    """Fork what is asked for; return that in each program, and None at the end."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # who waits for a program needs no waiting for
    line.send(str(time.process_time()).encode())
    while True:
        request, descriptors, _, _ = socket.recv_fds(line, LONGEST, 4)
        if not request:
            return None
        if not os.fork():
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            line.close()
            asked = json.loads(request)
            _be(asked, *descriptors)
            return dict(asked)
        for one in descriptors:
            os.close(one)


def _be(asked: dict[str, Any], told: int, *streams: int) -> None:
    """Become the program, as the child of a process that tells its end."""
    program = os.fork()
    if program:
        news = socket.socket(fileno=told)
        for stream in streams:
            os.close(stream)  # a pipe ends with the program
        news.send(json.dumps({"pid": program}).encode())
        _, status, used = os.wait4(program, 0)
        end = {"code": os.waitstatus_to_exitcode(status), "spent_s": used.ru_utime + used.ru_stime}
        with suppress(OSError):  # nobody listens any more
            news.send(json.dumps(end).encode())
        os._exit(0)
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    os.close(told)
    os.chdir(asked["cwd"])
    os.environ.clear()
    os.environ.update(asked["environment"])
    sys.argv = asked["words"]


def main() -> None:
    """Load what a run needs, and fork."""
    from navigation.cli.main import main as clearway
    from navigation.config import load_config
    from navigation.run.kernels.warm_up import warm_up
    from navigation.run.runner import Runner  # noqa: F401 - with all that it imports

    warm_up(load_config(CONFIG, {}), print)
    gc.collect()
    assert len(os.listdir("/proc/self/task")) == 1, "a fork would lack a thread"
    gc.freeze()  # a program need not look through what it shares
    asked = _serve(socket.socket(fileno=int(sys.argv[1])))
    if asked is None:
        return
    if not asked["is_file"]:
        clearway()
    sys.path.insert(0, str(Path(sys.argv[0]).parent))
    runpy.run_path(sys.argv[0], run_name="__main__")


if __name__ == "__main__":
    main()
