"""The processes of one run: started in a folder, ended whatever happens.

Each is a session of its own, so that a signal to the judge reaches none of them by itself.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[2]


class ProcessError(RuntimeError):
    """A process did not come up; the message says which and what it said."""


class Process:
    """A program with its words in files of the run's folder.

    ``stdout``: a path to write to in place of the file.
    """

    def __init__(
        self, name: str, arguments: Sequence[str], folder: Path, stdout: Path | None = None
    ) -> None:
        self.name, self.folder = name, folder
        self.out = stdout or folder / f"{name}.out"
        self.err = folder / f"{name}.err"
        paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
        environment = {
            **os.environ,
            # byte code cut off by a limit on files would stay, and break every later start
            "PYTHONDONTWRITEBYTECODE": "1",
            "PYTHONPATH": os.pathsep.join(paths),
            "PYTHONUNBUFFERED": "1",
            # stops of another run, on a line of the same name, hold none of this one
            "XDG_STATE_HOME": str(folder / "state"),
            "OPENCV_LOG_LEVEL": "SILENT",
            "OPENCV_FFMPEG_LOGLEVEL": "-8",
        }
        with self.out.open("ab") as out, self.err.open("ab") as err:
            self.popen = subprocess.Popen(
                list(arguments),
                cwd=folder,
                stdin=subprocess.PIPE,
                stdout=out,
                stderr=err,
                start_new_session=True,
                env=environment,
            )

    @property
    def runs(self) -> bool:
        return self.popen.poll() is None

    def say(self, line: str) -> None:
        """A line into its standard input; nothing where it has gone."""
        assert self.popen.stdin is not None
        with contextlib.suppress(OSError):
            self.popen.stdin.write(line.encode() + b"\n")
            self.popen.stdin.flush()

    def signal(self, number: int) -> None:
        with contextlib.suppress(ProcessLookupError):
            self.popen.send_signal(number)

    def first_line(self, within_s: float) -> str:
        """The first line that it says; ``ProcessError`` where none comes in time."""
        end_s = time.monotonic() + within_s
        while time.monotonic() < end_s and self.runs:
            line, mark, _ = self.out.read_text().partition("\n")
            if mark:
                return line
            time.sleep(0.02)  # a file tells nobody that it has grown
        raise ProcessError(f"{self.name} said nothing within {within_s:g} s: {self.last_words()}")

    def last_words(self) -> str:
        """The last line on its standard error, else output."""
        for file in (self.err, self.out):
            if file.is_file():
                lines = file.read_text(errors="replace").strip().splitlines()
                if lines:
                    return lines[-1][:300]
        return "nothing"

    def end(self) -> None:
        """Kill it and what it has started: all there is to know of it is known."""
        if self.popen.stdin is not None:
            with contextlib.suppress(OSError):
                self.popen.stdin.close()
        if self.runs:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.popen.pid, signal.SIGKILL)  # its session is its own
        self.popen.wait()


def children(pid: int) -> dict[int, str]:
    """The processes that a process has started, and each one's command line."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has just ended
            # its name, in brackets, may hold anything; its parent is the second word after it
            if int((folder / "stat").read_text().rpartition(")")[2].split()[1]) == pid:
                words = (folder / "cmdline").read_bytes().split(b"\0")
                found[int(folder.name)] = b" ".join(words).decode(errors="replace")
    return found


def lives(pid: int) -> bool:
    """True if there is such a process, and it is more than a name that waits for its parent."""
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def clearway(*words: str | Path) -> list[str]:
    """The command line of this environment's `clearway`."""
    return [str(Path(sys.executable).with_name("clearway")), *map(str, words)]


def module(name: str, *words: str | Path) -> list[str]:
    """The command line of one of the programs of `stage`."""
    return [sys.executable, "-m", f"benchmarks.adversary.stage.{name}", *map(str, words)]
