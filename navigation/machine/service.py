"""The systemd unit and the udev rule that make Clearway a service of this machine.

Rules
- Ready when ready (Type=notify), restarted when a stage hangs (WatchdogSec), not restarted for ever
  (StartLimit), and never for a bad configuration (exit code 78).
- The service may write only to its own cache, state and runtime directories, and to its serial
  ports and cameras. It must be able to make code executable: kernels are compiled.
- A user's own service has no hardening that the user's manager could refuse.

Sources: systemd.exec(5), systemd.service(5), udev(7).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

NAME: Final = "clearway"
WATCHDOG_S: Final = 40
"""Four times the longest that a stage waits between two attempts at a lost camera."""
START_S: Final = 900
"""Longest first start, which compiles the kernels: minutes on a small machine."""
BAD_CONFIGURATION: Final = 78

UNIT_FOLDER: Final = Path("etc/systemd/system")
UDEV_FOLDER: Final = Path("etc/udev/rules.d")
RULE_FILE: Final = f"70-{NAME}.rules"
SYMLINK: Final = "clearway-robot"


class ServiceError(ValueError):
    """A service that cannot be installed; the message says why."""


@dataclass(frozen=True, slots=True)
class UsbAdapter:
    """A serial adapter's identity for udev: four hexadecimal digits each, and its serial number."""

    vendor: str
    product: str
    serial: str | None = None


def unit_text(program: Path, config: Path, *, user: bool, run_as: str | None = None) -> str:
    """Unit that runs ``config``; ``user``: for a user's own manager.

    ``run_as`` is an account of this machine; None lets systemd create one (DynamicUser). Both paths
    must be absolute.
    """
    for path in (program, config):
        if not path.is_absolute():
            raise ServiceError(f"{path}: must be an absolute path in a unit")
    runtime = "%t/clearway"
    start = f"{_quoted(program)} run {_quoted(config)} --quiet --log-format text"
    lines = [
        "# Made by `clearway install-service`.",
        "[Unit]",
        "Description=Clearway: a robot on the path with the largest clearance",
        "After=local-fs.target network.target",
        "StartLimitIntervalSec=300",
        "StartLimitBurst=5",
        "",
        "[Service]",
        "Type=notify",
        "NotifyAccess=main",
        f"ExecStart={start} --socket {runtime}/socket",
        "ExecReload=/bin/kill -HUP $MAINPID",
        f"WatchdogSec={WATCHDOG_S}",
        "WatchdogSignal=SIGTERM",
        f"TimeoutStartSec={START_S}",
        "TimeoutStopSec=10",
        "Restart=on-failure",
        "RestartSec=2",
        f"RestartPreventExitStatus={BAD_CONFIGURATION}",
        f"CacheDirectory={NAME}",
        f"StateDirectory={NAME}",
        f"RuntimeDirectory={NAME}",
        "RuntimeDirectoryMode=0700",
        "RuntimeDirectoryPreserve=restart",
        "WorkingDirectory=%S/clearway",
        "UMask=0077",
        "NoNewPrivileges=yes",
    ]
    if not user:
        account = ["DynamicUser=yes"] if run_as is None else [f"User={_account(run_as)}"]
        lines += [*account, "SupplementaryGroups=dialout video", *_HARDENING]
    target = "default.target" if user else "multi-user.target"
    return "\n".join([*lines, "", "[Install]", f"WantedBy={target}"]) + "\n"


_HARDENING: Final = (
    "ProtectSystem=strict",
    "ProtectHome=read-only",
    "PrivateTmp=yes",
    "ProtectKernelTunables=yes",
    "ProtectKernelModules=yes",
    "ProtectKernelLogs=yes",
    "ProtectControlGroups=yes",
    "ProtectClock=yes",
    "ProtectHostname=yes",
    "RestrictSUIDSGID=yes",
    "RestrictRealtime=yes",
    "RestrictNamespaces=yes",
    "RestrictAddressFamilies=AF_UNIX AF_INET AF_INET6 AF_NETLINK",
    "LockPersonality=yes",
    "CapabilityBoundingSet=",
    "SystemCallArchitectures=native",
    "SystemCallFilter=@system-service",
    "DevicePolicy=closed",
    "DeviceAllow=char-ttyUSB rw",
    "DeviceAllow=char-ttyACM rw",
    "DeviceAllow=char-ttyS rw",
    "DeviceAllow=char-video4linux rw",
    "DeviceAllow=char-pts rw",
    "DeviceAllow=/dev/ptmx rw",
)


def udev_text(adapter: UsbAdapter) -> str:
    """Rule that gives a serial adapter one name and keeps ModemManager off it."""
    match = [
        'SUBSYSTEM=="tty"',
        f'ATTRS{{idVendor}}=="{_hex(adapter.vendor)}"',
        f'ATTRS{{idProduct}}=="{_hex(adapter.product)}"',
    ]
    if adapter.serial is not None:
        match.append(f'ATTRS{{serial}}=="{_serial(adapter.serial)}"')
    rule = [*match, 'GROUP="dialout"', 'MODE="0660"', 'TAG+="uaccess"', f'SYMLINK+="{SYMLINK}"']
    return (
        "# Made by `clearway install-service`: the robot's serial adapter.\n"
        + ", ".join([*rule, 'ENV{ID_MM_DEVICE_IGNORE}="1"'])
        + "\n"
    )


def adapter_of(port: str) -> UsbAdapter | None:
    """USB adapter behind a port; None if there is none, or it is not plugged in."""
    import os

    from serial.tools import list_ports

    real = os.path.realpath(port)
    for found in list_ports.comports():
        if os.path.realpath(found.device) == real and found.vid is not None:
            serial = found.serial_number if found.serial_number else None
            return UsbAdapter(f"{found.vid:04x}", f"{found.pid:04x}", serial)
    return None


def _quoted(path: Path) -> str:
    """Quote a path for systemd's ExecStart, doubling its specifiers and variables."""
    text = str(path).replace("%", "%%").replace("$", "$$")
    if re.fullmatch(r"[\w./%+@:,=-]+", text):
        return text
    if any(ord(c) < 32 for c in text):
        raise ServiceError(f"{path}: a path with control characters cannot be in a unit")
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _account(name: str) -> str:
    if not re.fullmatch(r"[a-z_][a-z0-9_-]*\$?", name):
        raise ServiceError(f"'{name}': is no name of an account")
    return name


def _hex(text: str) -> str:
    if not re.fullmatch(r"[0-9a-f]{4}", text):
        raise ServiceError(f"'{text}': must be four hexadecimal digits")
    return text


def _serial(text: str) -> str:
    if not re.fullmatch(r"[\w .:/+-]+", text, flags=re.ASCII):
        raise ServiceError(f"the adapter's serial number {text!r} cannot be in a udev rule")
    return text
