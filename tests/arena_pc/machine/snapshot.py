"""States of the machine, kept in files: to restore one takes seconds, to reach it a minute or two.

A snapshot is beside the disks, under a hash of all that it depends on: QEMU's version, the
machine's parts, and what was done in it. The disks are read-only, and what the guest has written is
in its memory. Nothing is plugged in while a snapshot is taken.
"""

from __future__ import annotations

import fcntl
import hashlib
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from tests.arena_pc.machine.json_lines import GoneError
from tests.arena_pc.machine.pc import EMULATOR, ArenaPC, machine

BOOT_WITHIN_S = 300.0
COMMAND_WITHIN_S = 600.0
SAVE_WITHIN_S = 120.0
RESTORE_WITHIN_S = 60.0
LOOK_EVERY_S = 0.05


@dataclass(frozen=True, slots=True)
class State:
    """Where a test begins: files and commands that lead there, after another state or a boot."""

    name: str
    commands: tuple[str, ...]
    files: tuple[tuple[str, str], ...] = ()
    after: State | None = None


BOOTED = State(
    "booted",
    (
        "systemctl is-system-running --wait",
        "modprobe -a uvcvideo ftdi_sio",
        "clearway devices",  # the program's files are in memory then
        "sync",
    ),
)


def restored(image: Path, state: State, work: Path) -> ArenaPC:
    """A machine in a state; the first time it is led there, by one process."""
    file = _file(image, state)
    with file.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not file.exists():
            with tempfile.TemporaryDirectory(prefix="arena-") as folder:
                _take(image, state, Path(folder), file)
    pc = ArenaPC(image, work, ["-incoming", f"exec:zstd -dcq '{file}'"])
    try:
        _wait_for_status(pc, "query-status", {"paused", "running"}, RESTORE_WITHIN_S)
        pc.qmp("cont")
    except (GoneError, TimeoutError):
        pc.switch_off()
        raise
    return pc


def _file(image: Path, state: State) -> Path:
    version = subprocess.run([EMULATOR, "--version"], capture_output=True, text=True, check=True)
    depends_on = repr((version.stdout, machine(image), state))
    return image / f"{state.name}-{hashlib.sha256(depends_on.encode()).hexdigest()[:16]}.zst"


def _take(image: Path, state: State, work: Path, file: Path) -> None:
    with _led_to_its_begin(image, state, work) as pc:
        for name, text in state.files:
            pc.write(name, text)
        for command in state.commands:
            pc.check(command, COMMAND_WITHIN_S)
        pc.qmp("stop")
        unfinished = file.with_suffix(".unfinished")
        pc.qmp("migrate", uri=f"exec:zstd -1 -q -f -o '{unfinished}'")
        _wait_for_status(pc, "query-migrate", {"completed"}, SAVE_WITHIN_S)
    unfinished.rename(file)


def _led_to_its_begin(image: Path, state: State, work: Path) -> ArenaPC:
    if state.after is not None:
        return restored(image, state.after, work)
    pc = ArenaPC(image, work)
    try:
        pc.wait_for_agent(BOOT_WITHIN_S)
    except (GoneError, TimeoutError) as error:
        pc.switch_off()
        raise GoneError(f"the machine does not boot: {error}\n{pc.logs()}") from error
    return pc


def _wait_for_status(pc: ArenaPC, query: str, wanted: set[str], within_s: float) -> None:
    """Ask QEMU until the status is one of those wanted."""
    end_s = time.monotonic() + within_s
    while (status := pc.qmp(query).get("status")) not in wanted:
        if status == "failed" or time.monotonic() > end_s:
            raise GoneError(f"{query}: {status} after {within_s:g} s at most\n{pc.logs()}")
        time.sleep(LOOK_EVERY_S)  # QEMU is asked how far it has come
