"""Children end with their parent, whatever ends it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from navigation.machine.child import start_child
from tests.support.waiting import wait_until

ONE_CHILD = """
import sys, time
from navigation.machine.child import start_child
print(start_child(time.sleep, 600.0).pid, flush=True)
time.sleep(600.0)  # until it is killed
"""
WORKERS = """
import os, time
from navigation.sweep.workers import local_executor
executor = local_executor(2)
workers = {executor.submit(os.getpid).result() for _ in range(20)}
busy = executor.submit(time.sleep, 600.0)
print(*workers, flush=True)
time.sleep(600.0)  # until it is killed
"""


def is_there(pid: int) -> bool:
    """Whether the process runs; one that has ended and waits to be buried does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize(
    ("program", "number"),
    [
        (ONE_CHILD, signal.SIGKILL),
        (ONE_CHILD, signal.SIGTERM),
        (ONE_CHILD, signal.SIGINT),
        (WORKERS, signal.SIGKILL),
        (WORKERS, signal.SIGTERM),
    ],
)
def test_children_end_with_a_parent_that_is_ended(program: str, number: int) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as parent:
        assert parent.stdout is not None
        children = [int(word) for word in parent.stdout.readline().split()]
        assert children
        assert all(is_there(pid) for pid in children)
        parent.send_signal(number)
    assert wait_until(lambda: not any(is_there(pid) for pid in children), 5.0)


def test_a_child_does_its_work_and_its_failure_is_its_exit_code() -> None:
    well, ill = start_child(os.getpid), start_child(os.chdir, "/nowhere at all")
    well.join()
    ill.join()
    assert (well.exitcode, ill.exitcode) == (0, 1)
