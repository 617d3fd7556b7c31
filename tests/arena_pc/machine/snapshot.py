"""A machine that has booted, kept in a file: to restore it takes seconds, to boot it a minute.

The snapshot is beside the disks, under a hash of all that it depends on: QEMU's version and the
machine's parts. The disks are read-only, and what the guest has written is in its memory.
"""

from __future__ import annotations

import hashlib
import subprocess
import time
from pathlib import Path

from tests.arena_pc.machine.json_lines import Gone
from tests.arena_pc.machine.pc import EMULATOR, ArenaPC, machine

BOOT_WITHIN_S = 300.0
SAVE_WITHIN_S = 120.0
RESTORE_WITHIN_S = 60.0
LOOK_EVERY_S = 0.05
PREPARE = (
    "systemctl is-system-running --wait; modprobe -a uvcvideo ftdi_sio && "
    "clearway devices && sync"
)
"""What every test would wait for: the end of the boot, drivers, the program's files in memory."""


def snapshot_of(image: Path) -> Path:
    """The file of a machine's snapshot, which is made where there is none yet."""
    version = subprocess.run([EMULATOR, "--version"], capture_output=True, text=True, check=True)
    depends_on = repr((version.stdout, machine(image), PREPARE))
    return image / f"snapshot-{hashlib.sha256(depends_on.encode()).hexdigest()[:16]}.zst"


def take(image: Path, work: Path, file: Path) -> None:
    """Boot a machine and write its state into a file."""
    with ArenaPC(image, work) as pc:
        try:
            pc.wait_for_agent(BOOT_WITHIN_S)
        except TimeoutError as error:
            raise Gone(f"the machine does not boot: {error}\n{pc.logs()}") from error
        pc.check(PREPARE, BOOT_WITHIN_S)
        pc.qmp("stop")
        unfinished = file.with_suffix(".unfinished")
        pc.qmp("migrate", uri=f"exec:zstd -1 -q -f -o '{unfinished}'")
        wait_for_status(pc, "query-migrate", {"completed"}, SAVE_WITHIN_S)
        pc.qmp("quit")
    unfinished.rename(file)


def restore(image: Path, work: Path, file: Path) -> ArenaPC:
    """A machine that runs on from a snapshot."""
    pc = ArenaPC(image, work, ["-incoming", f"exec:zstd -dcq '{file}'"])
    try:
        wait_for_status(pc, "query-status", {"paused", "running"}, RESTORE_WITHIN_S)
        pc.qmp("cont")
    except (Gone, TimeoutError):
        pc.switch_off()
        raise
    return pc


def wait_for_status(pc: ArenaPC, query: str, wanted: set[str], within_s: float) -> None:
    """Ask QEMU until the status is one of those wanted."""
    end_s = time.monotonic() + within_s
    while (status := pc.qmp(query).get("status")) not in wanted:
        if status == "failed" or time.monotonic() > end_s:
            raise Gone(f"{query}: {status} after {within_s:g} s at most\n{pc.logs()}")
        time.sleep(LOOK_EVERY_S)
