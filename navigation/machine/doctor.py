"""Checks of this machine before a run: one finding a line, each with advice.

A check changes nothing and gets its inputs as arguments. `fail`: a run cannot work; `warn`: it may
disappoint. Sizes in MB are 10^6 bytes.
"""

from __future__ import annotations

import os
import re
import stat
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from importlib import metadata
from pathlib import Path
from typing import Final, Literal, TypeAlias

Status: TypeAlias = Literal["ok", "warn", "fail"]

LEAST_PYTHON: Final = (3, 11)
DISK_WARN_MB: Final = 2000.0
DISK_FAIL_MB: Final = 200.0
LEAST_CORES: Final = 2
WAKEUP_WARN_S: Final = 0.1
RELEASE_YEAR: Final = 2026
"""No clock can be earlier; a small computer without a battery starts in 1970 or 2000."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One line: the thing checked, its state, and advice if it is not well."""

    status: Status
    name: str
    sentence: str
    cure: str = ""


def worst(findings: Iterable[Finding]) -> Status:
    """Return the worst status; ``ok`` for no findings."""
    order: tuple[Status, ...] = ("ok", "warn", "fail")
    return max((f.status for f in findings), key=order.index, default="ok")


def check_python(version: tuple[int, int] = sys.version_info[:2]) -> Finding:
    """Check the interpreter."""
    told = f"{version[0]}.{version[1]}"
    if version < LEAST_PYTHON:
        wanted = ".".join(map(str, LEAST_PYTHON))
        return Finding("fail", "python", told, f"install Python {wanted} or newer")
    return Finding("ok", "python", told)


def check_packages(
    wanted: Iterable[str], installed: Callable[[str], str] = metadata.version
) -> Iterator[Finding]:
    """Check Clearway's requirements, given as by ``importlib.metadata.requires``."""
    fine = []
    for line in wanted:
        if "extra ==" in line:
            continue
        name, least = _requirement(line)
        try:
            found = installed(name)
        except metadata.PackageNotFoundError:
            yield Finding("fail", "packages", f"{name} is missing", f"pip install '{line}'")
            continue
        if _numbers(found) < _numbers(least):
            sentence = f"{name} {found}: must be >= {least}"
            yield Finding("fail", "packages", sentence, f"pip install '{line}'")
        else:
            fine.append(f"{name} {found}")
    if fine:
        yield Finding("ok", "packages", ", ".join(fine))


def _requirement(line: str) -> tuple[str, str]:
    name = re.match(r"[\w.-]+", line)
    least = re.search(r">=\s*([\d.]+)", line)
    assert name is not None, line
    return name.group(), least.group(1) if least else "0"


def _numbers(version: str) -> tuple[int, ...]:
    numbers = [int(n) for n in re.findall(r"\d+", re.split(r"[a-z+]", version)[0])]
    while numbers and numbers[-1] == 0:
        numbers.pop()
    return tuple(numbers)


def check_opencv_twice(names: Iterable[str]) -> Finding | None:
    """Check for several OpenCVs, which overwrite each other; ``names`` are distributions."""
    found = sorted({n for n in names if re.fullmatch(r"opencv[-_].*python.*", n)})
    if len(found) < 2:
        return None
    return Finding(
        "fail",
        "packages",
        f"{', '.join(found)} are installed together and overwrite each other",
        f"pip uninstall -y {' '.join(found)}; pip install opencv-contrib-python-headless",
    )


def check_writable(name: str, folder: Path) -> Finding:
    """Check a folder that the program makes or writes to."""
    at = _nearest_there(folder)
    if not at.is_dir():
        return Finding("fail", name, f"{at}: is no folder", f"remove {at} or choose another")
    if not os.access(at, os.W_OK | os.X_OK):
        return Finding("fail", name, f"{at}: cannot be written to", f"sudo chown $USER {at}")
    return Finding("ok", name, f"{folder}")


def _nearest_there(folder: Path) -> Path:
    return next((one for one in (folder, *folder.parents) if one.exists()), folder)


def check_disk(folder: Path, free_bytes: Callable[[Path], int]) -> Finding:
    """Check the free space for reports and recordings."""
    at = _nearest_there(folder.absolute())
    free_mb = free_bytes(at) / 1e6
    told = f"{free_mb:.0f} MB are free at {at}"
    if free_mb < DISK_FAIL_MB:
        return Finding("fail", "disk", told, f"free {DISK_FAIL_MB:g} MB, or record elsewhere")
    if free_mb < DISK_WARN_MB:
        cure = "make room before recording, or lower recording.limit_mb"
        return Finding("warn", "disk", told, cure)
    return Finding("ok", "disk", told)


def check_clock(now: datetime, synchronised: bool | None) -> Finding:
    """Check the wall clock, which stamps logs and recordings; runs do not use it."""
    told = f"{now:%Y-%m-%d %H:%M:%S}"
    if now.year < RELEASE_YEAR:
        cure = "set the clock (timedatectl set-ntp true)"
        return Finding("warn", "clock", f"{told} is in the past", cure)
    if synchronised is False:
        cure = "timedatectl set-ntp true, so that recordings of several machines agree"
        return Finding("warn", "clock", f"{told}, not synchronised", cure)
    return Finding("ok", "clock", told + (", synchronised" if synchronised else ""))


def check_cores(count: int | None) -> Finding:
    """Check the processor's cores, which vision, planner, link and page share."""
    if count is not None and count < LEAST_CORES:
        cure = "lower camera.rate_hz and run with --no-dashboard"
        return Finding("warn", "processor", f"{count} core", cure)
    return Finding("ok", "processor", f"{count or 'an unknown number of'} cores")


def check_wakeups(worst_s: float, load: float) -> Finding:
    """Check the delay in waking threads: robots hold if it is too long."""
    told = f"woken at most {worst_s * 1e3:.0f} ms late, load {load:.1f}"
    if worst_s > WAKEUP_WARN_S:
        cure = "end what else runs: robots hold while the program is late"
        return Finding("warn", "threads", told, cure)
    return Finding("ok", "threads", told)


def check_device(name: str, path: Path, group: str, groups: Iterable[str]) -> Finding:
    """Check that a serial port or camera exists and may be read and written."""
    try:
        mode = path.stat().st_mode
    except OSError as error:
        cure = "plug it in, and choose its name from `clearway devices`"
        return Finding("fail", name, f"{path}: {error.strerror or error}", cure)
    if not stat.S_ISCHR(mode):
        cure = "choose a name from `clearway devices`"
        return Finding("fail", name, f"{path}: is no device", cure)
    if os.access(path, os.R_OK | os.W_OK):
        return Finding("ok", name, f"{path} may be read and written")
    if group in groups:
        cure = "log out and in again, or look at the udev rules"
        return Finding("fail", name, f"{path}: no permission, in spite of group {group}", cure)
    cure = f"sudo usermod -aG {group} $USER, then log out and in"
    return Finding("fail", name, f"{path}: no permission", cure)


def own_groups() -> list[str]:
    """Names of this process's groups."""
    import grp  # only Unix has it

    names = []
    for number in {os.getgid(), *os.getgroups()}:
        try:
            names.append(grp.getgrgid(number).gr_name)
        except KeyError:
            continue
    return names


PORT_TAKERS = {
    "ModemManager": (
        "ModemManager is running, and talks to serial ports that it does not know",
        "install the udev rule of `clearway install-service`, or disable ModemManager",
    ),
    "brltty": (
        "brltty (for Braille displays) is running, and takes CP210x, CH340 and FTDI ports away:"
        " /dev/ttyUSB0 vanishes a second after it has appeared",
        "unless a Braille display is used here: `sudo apt remove brltty`, then plug the robot in"
        " again",
    ),
}
"""Programs that take serial ports for their own devices: what they do, and the cure."""


def check_port_takers(running: Iterable[str]) -> Iterator[Finding]:
    """Warn of each of the ``running`` programs that may take the robot's port."""
    here = set(running)
    for name, (sentence, fix) in PORT_TAKERS.items():
        if name in here:
            yield Finding("warn", "serial port", sentence, fix)


def running_programs(proc: Path = Path("/proc")) -> Iterator[str]:
    """Names of the running programs."""
    for comm in proc.glob("[0-9]*/comm"):
        try:
            yield comm.read_text().strip()
        except OSError:
            continue


def check_kernels(cold: bool, folder: Path | None, environment: Mapping[str, str]) -> Finding:
    """Check that the kernels are compiled, and name their folder."""
    where = environment.get("NUMBA_CACHE_DIR") or (str(folder) if folder else "beside the source")
    if cold:
        cure = "nothing to do: the first run compiles them, which takes some minutes"
        return Finding("warn", "kernels", f"not compiled yet (kept in {where})", cure)
    return Finding("ok", "kernels", f"compiled, kept in {where}")
