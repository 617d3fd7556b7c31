"""Attacks on its files: no room, nobody to read, a lock held by somebody else, a folder removed."""

from __future__ import annotations

import contextlib
import fcntl
import resource
import shutil
import time
from pathlib import Path

from benchmarks.adversary.attacks.attack import Attack
from benchmarks.adversary.processes import ProcessError
from benchmarks.adversary.rig import Needs, Rig
from tests.support.waiting import wait_until

LOCKED_S = 2.0
BACK_WITHIN_S = 1.0
FULL_BYTES = 4096
"""No file grows beyond this any more; the journal and every log are larger."""


def _no_room(rig: Rig) -> None:
    """Every file is full from now on; a new plan has to be kept."""
    pid = rig.daemon.popen.pid
    hard = resource.prlimit(pid, resource.RLIMIT_FSIZE)[1]
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (FULL_BYTES, hard))
    rig.watch(2.0)
    rig.order(order="replan")
    rig.watch_mission(4.0)


def _nobody_reads(rig: Rig) -> None:
    rig.watch_mission(6.0)


def _locked(rig: Rig) -> None:
    """Twice for 2 s, while a new plan has to be kept; the stop comes in the second."""
    with (rig.folder / ".journal.lock").open("rb") as other:
        for number in range(2):
            with contextlib.suppress(BlockingIOError):  # the program keeps others out
                fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)
            until_s = time.monotonic() + LOCKED_S
            rig.order(order="replan")
            rig.watch(0.5)
            if number == 1:
                rig.stop()
            rig.watch(until_s - time.monotonic())
            fcntl.flock(other, fcntl.LOCK_UN)
            rig.watch(2.0)


def _socket_removed(rig: Rig) -> None:
    """Twice: as the last logout removes a user's folder. The stop comes before it is back."""
    shutil.rmtree(rig.socket.parent)
    if not wait_until(rig.socket.is_socket, BACK_WITHIN_S):
        raise ProcessError(f"the socket was not there again after {BACK_WITHIN_S:g} s")
    rig.watch_mission(1.0)
    rig.note_end()
    shutil.rmtree(rig.socket.parent)
    rig.stop()
    rig.watch(1.0)


ATTACKS = (
    Attack("disk", "no room for any file", _no_room, Needs(recorded=True)),
    Attack("disk", "standard output is full", _nobody_reads, Needs(stdout=Path("/dev/full"))),
    Attack("disk", "the journal locked for 2 s", _locked),
    Attack("disk", "the socket's folder removed", _socket_removed),
)
