"""A Python that has imported what many runs need, and forks for each of them.

Each run has its own module, arguments and output, as that of a new Python would; it
does not pay for the imports.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

SERVER = """
import json, os, sys, traceback

exec(sys.argv[1])
for line in sys.stdin:
    asked = json.loads(line)
    child = os.fork()
    if not child:
        for number, file in ((1, "out"), (2, "err")):
            os.dup2(os.open(asked[file], os.O_WRONLY), number)
        sys.argv = ["-c", *asked["arguments"]]
        status = 1
        try:
            exec(compile(asked["code"], "<forked>", "exec"), {"__name__": "__main__"})
            sys.stdout.flush()
            status = 0
        except BaseException:
            traceback.print_exc()
        sys.stderr.flush()
        os._exit(status)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


class Done(NamedTuple):
    """What a run has said; ``status`` is 0 where it ended in order."""

    status: int
    out: str
    err: str


class Forked:
    """The Python that forks, in the folder ``cwd``; ``prepare`` is what it does first."""

    def __init__(self, prepare: str, *, cwd: Path, environment: dict[str, str]) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-c", SERVER, prepare],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=cwd,
            env={**os.environ, **environment},
        )

    def __enter__(self) -> Forked:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.communicate()

    def run(self, code: str, *arguments: str) -> Done:
        """Run ``code`` in a fork, and wait for its end."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with tempfile.NamedTemporaryFile("r") as out, tempfile.NamedTemporaryFile("r") as err:
            asked = {"code": code, "arguments": arguments, "out": out.name, "err": err.name}
            print(json.dumps(asked), file=self._process.stdin, flush=True)
            status = int(self._process.stdout.readline())
            return Done(status, out.read(), err.read())
