"""`clearway install-service`: a systemd unit and a udev rule."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import click


@click.command(short_help="A systemd unit, and a udev rule for the robot's port.")
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--user", is_flag=True, help="A service of yours alone, without root.")
@click.option("--run-as", metavar="ACCOUNT", help="Account of the service; default: sudo's caller.")
@click.option("--print", "only_print", is_flag=True, help="Print the files, write nothing.")
@click.option(
    "--root",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("/"),
    help="Write below this folder instead of /, for packages.",
)
def command(config: Path, user: bool, run_as: str | None, only_print: bool, root: Path) -> None:
    """Install a service that runs the configuration CONFIG.

    Writes clearway.service and, for a USB serial adapter that is plugged in, a udev rule that
    names it /dev/clearway-robot. The configuration is checked first; nothing is started.
    """
    from navigation.cli.setup.check import load_checked
    from navigation.machine.service import NAME, RULE_FILE, UDEV_FOLDER, UNIT_FOLDER, unit_text

    loaded = load_checked(config)
    run_as = run_as or os.environ.get("SUDO_USER")
    unit = unit_text(_program(), config.resolve(), user=user, run_as=run_as)
    folder = _user_folder() if user else root / UNIT_FOLDER
    files = {folder / f"{NAME}.service": unit}
    rule = None if user else _rule(loaded.serial.port)
    if rule is not None:
        files[root / UDEV_FOLDER / RULE_FILE] = rule
    if only_print:
        for file, text in files.items():
            click.echo(f"# {file}\n{text}")
        return
    for file, text in files.items():
        _write(file, text)
    _verify(folder / f"{NAME}.service")
    manager = "systemctl --user" if user else "systemctl"
    click.echo(f"next: {manager} daemon-reload && {manager} enable --now {NAME}")
    if rule is not None:
        click.echo("      udevadm control --reload && udevadm trigger --subsystem-match=tty")
    click.echo(f"then: journalctl {'--user ' if user else ''}-u {NAME} -f")


def _program() -> Path:
    beside = Path(sys.executable).parent / "clearway"
    if not beside.exists():
        raise click.UsageError(f"{beside}: there is no such program; install the package first")
    return beside


def _user_folder() -> Path:
    config_home = os.environ.get("XDG_CONFIG_HOME")
    base = Path(config_home) if config_home else Path.home() / ".config"
    return base / "systemd" / "user"


def _rule(port: str) -> str | None:
    from navigation.config.values import SIMULATED
    from navigation.machine.service import adapter_of, udev_text

    if port == SIMULATED:
        return None
    adapter = adapter_of(port)
    if adapter is None:
        click.echo(
            f"{port}: no USB adapter is plugged in there, so there is no udev rule", err=True
        )
        return None
    return udev_text(adapter)


def _write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
    file.chmod(0o644)
    click.echo(f"wrote {file}")


def _verify(unit: Path) -> None:
    program = shutil.which("systemd-analyze")
    if program is None:
        return
    told = subprocess.run(
        [program, "verify", str(unit)], capture_output=True, text=True, timeout=60, check=False
    )
    for line in told.stderr.splitlines():
        click.echo(f"systemd-analyze: {line}", err=True)
