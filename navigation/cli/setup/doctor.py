"""`clearway doctor`: a machine's fitness for a run."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import time
from collections.abc import Iterator
from dataclasses import asdict, replace
from datetime import datetime
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from navigation.cli.options import format_option
from navigation.config.secrecy.secrets import hide, hide_in

if TYPE_CHECKING:
    from navigation.config import Config
    from navigation.machine.doctor import Finding

WELL, ILL = 0, 1
WATCHED_S = 2.0
"""Shorter than `clearway camera` watches it."""
COLOURS = {"ok": "green", "warn": "yellow", "fail": "red"}

WAKEUPS_SEEN_S: Final = 1.0


@click.command(short_help="Whether this machine can do the run.")
@click.argument("config", type=click.Path(path_type=Path), required=False)
@format_option()
@click.option(
    "--bundle",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE.zip",
    help="Pack findings, versions, configuration, last report and recording for a bug report.",
)
def command(config: Path | None, form: str, bundle: Path | None) -> int:
    """Look at permissions, camera, serial port, cache, kernels, clock, disk and packages.

    With a configuration CONFIG its camera, port and folders are checked, otherwise the plugged-in
    devices. Each line says ok, warn or fail, and how to fix it. Exits 1 if something fails.
    """
    from navigation.machine.doctor import worst

    configured, loaded = configuration_findings(config)
    findings = [*machine_findings(), *configured]
    if form == "json":
        body = {"schema": "clearway.doctor/1", "findings": [asdict(f) for f in findings]}
        click.echo(json.dumps(hide_in(body), indent=2))
    else:
        for finding in findings:
            show_finding(finding)
    if bundle is not None:
        from navigation.machine.bundle import write_bundle

        names = write_bundle(bundle, config, loaded, findings, os.environ, datetime.now())
        click.echo(f"wrote {bundle}: {', '.join(names)}; look through it before you send it")
    return ILL if worst(findings) == "fail" else WELL


def show_finding(finding: Finding) -> None:
    """Print a finding, and its remedy on a second line."""
    status = click.style(f"{finding.status:<4}", fg=COLOURS[finding.status])
    click.echo(hide(f"{status}  {finding.name:<14}{finding.sentence}"))
    if finding.cure:
        click.echo(hide(f"{'':<20}-> {finding.cure}"))


def machine_findings() -> Iterator[Finding]:
    """Yield findings that apply to every configuration."""
    import planner  # chooses the kernels' folder
    from navigation.config.last_good import state_folder
    from navigation.control import default_socket
    from navigation.machine import doctor
    from navigation.run.kernels.warm_up import kernels_are_cold

    yield doctor.check_python()
    yield from doctor.check_packages(metadata.requires("clearway") or [])
    twice = doctor.check_opencv_twice(d.name for d in metadata.distributions())
    if twice is not None:
        yield twice
    yield doctor.check_cores(os.cpu_count())
    yield doctor.check_wakeups(_latest_wakeup_s(), os.getloadavg()[0])
    yield doctor.check_clock(datetime.now(), _is_synchronised())
    folder = Path(planner.__file__).parent / "__pycache__"
    yield doctor.check_kernels(kernels_are_cold(), folder, os.environ)
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    yield doctor.check_writable("kernel folder", Path(chosen) if chosen else folder)
    yield doctor.check_writable("state folder", state_folder(os.environ))
    yield doctor.check_writable("order socket", default_socket().parent)


def configuration_findings(file: Path | None) -> tuple[list[Finding], Config | None]:
    """Findings for this configuration, or for the plugged-in devices if there is none."""
    from navigation.cli.setup.check import load_checked
    from navigation.config.errors import ConfigError
    from navigation.machine import doctor

    if file is None:
        found = [doctor.check_disk(Path(), _free_bytes)]
        return [*found, *_plugged_in()], None
    try:
        config = load_checked(file)
    except ConfigError as error:
        cure = f"clearway check {file} reports the same; docs/configuration.md lists every key"
        return [doctor.Finding("fail", "configuration", str(error), cure)], None
    recording = config.recording
    fullest = recording.folder if recording.record else recording.runs_dir
    findings = [
        doctor.Finding("ok", "configuration", str(file)),
        doctor.check_writable("runs", recording.runs_dir),
        doctor.check_disk(fullest, _free_bytes),
    ]
    if recording.record:
        findings.append(doctor.check_writable("recordings", recording.folder))
    return [*findings, *_camera(config), *_port(config)], config


def _plugged_in() -> Iterator[Finding]:
    from navigation.cli.setup.devices import cameras_here, serial_ports
    from navigation.machine.doctor import (
        Finding,
        check_device,
        check_port_takers,
        own_groups,
        running_programs,
    )

    yield from check_port_takers(running_programs())
    kinds = (("cameras", cameras_here(), "video"), ("serial ports", serial_ports(), "dialout"))
    for name, found, group in kinds:
        paths = [device["path"] for device in found]
        if paths:
            yield Finding("ok", name, ", ".join(paths))
        else:
            cure = "plug one in; a simulated run (`clearway init`) needs none"
            yield Finding("warn", name, "none", cure)
        for path in paths:
            device = check_device(name, Path(path), group, own_groups())
            if device.status != "ok":
                yield replace(device, status="warn")


def _camera(config: Config) -> Iterator[Finding]:
    from navigation.config.several.each_camera import each_camera

    if not config.cameras:
        yield from _one_camera(config)
    for name, one in each_camera(config).items():
        for finding in _one_camera(one):
            yield replace(finding, name=f"camera {name}")


def _one_camera(config: Config) -> Iterator[Finding]:
    from navigation.config.values import SIMULATED
    from navigation.machine import doctor

    source = config.camera.source
    if source == SIMULATED:
        yield doctor.Finding("ok", "camera", "simulated")
        return
    device = f"/dev/video{source}" if isinstance(source, int) else source
    if device.startswith("/dev/"):
        finding = doctor.check_device("camera", Path(device), "video", doctor.own_groups())
        yield finding
        if finding.status == "fail":
            return
    yield from _pictures(config)


def _pictures(config: Config) -> Iterator[Finding]:
    from navigation.cli.setup.camera_watch import watch
    from navigation.machine.camera_findings import camera_findings
    from navigation.machine.doctor import Finding
    from vision.camera.camera import CameraError

    try:
        judged = watch(config.camera, config, WATCHED_S)
    except CameraError as error:
        cure = "choose a name from `clearway devices`; close other programs that use it"
        yield Finding("fail", "camera", str(error), cure)
        return
    found = [each for each in camera_findings(judged) if each.status != "ok"]
    if all(each.status != "fail" for each in found):
        (width, height), timing = judged.quality.size, judged.quality.timing
        rate = "" if timing is None else f", {timing.rate_hz:.1f} frames/s"
        yield Finding("ok", "camera", f"pictures of {width}x{height}{rate}")
    for each in found:
        yield replace(each, name="camera", sentence=f"{each.name}: {each.sentence}")


def _port(config: Config) -> Iterator[Finding]:
    from navigation.config.several.each_robot import robots_of
    from navigation.machine import doctor

    robots = robots_of(config)
    for name, one in robots.items():
        for finding in _one_port(one):
            yield replace(finding, name=f"{finding.name} {name}".rstrip())
    if any(_device_of(one) is not None for one in robots.values()):
        yield from doctor.check_port_takers(doctor.running_programs())


def _one_port(config: Config) -> Iterator[Finding]:
    """Check the device; with our own firmware without opening it, since that resets some robots."""
    from navigation.config.known_robots import CLEARWAY
    from navigation.config.values import SIMULATED
    from navigation.machine import doctor

    if config.serial.port == SIMULATED:
        yield doctor.Finding("ok", "serial port", "simulated")
        return
    if config.robot.driver != CLEARWAY:
        yield _robot(config)
    device = _device_of(config)
    if device is not None:
        yield doctor.check_device("serial port", device, "dialout", doctor.own_groups())


def _device_of(config: Config) -> Path | None:
    from navigation.config.values import SIMULATED
    from navigation.link.serial_port import is_address

    port = config.serial.port
    return None if port == SIMULATED or is_address(port) else Path(port)


def _robot(config: Config) -> Finding:
    """Check which robot answers; a greeting stops it, and it is not driven."""
    from navigation.link.drivers.recognise import recognise
    from navigation.link.serial_port import PortError
    from navigation.machine.doctor import Finding

    wanted, cure = config.robot.driver, "docs/robots.md has the wiring and the signs of each robot"
    try:
        found = recognise(config.serial.port, config.serial.baud, wanted)
    except PortError as error:
        return Finding("fail", "robot", str(error), "choose a name from `clearway devices`")
    if found.name is None:
        return Finding("fail", "robot", found.sentence, cure)
    if found.name != wanted:
        sentence = f"{found.sentence} answers, robot.driver asks for {wanted}"
        return Finding("fail", "robot", sentence, f"set robot.driver to {found.name}")
    if found.fault is not None:
        return Finding("warn", "robot", f"{found.sentence} answers; {found.fault}", cure)
    battery = "" if found.battery is None else f", its battery at {found.battery:.0%}"
    return Finding("ok", "robot", f"{found.sentence} answers{battery}")


def _free_bytes(folder: Path) -> int:
    return shutil.disk_usage(folder).free


def _latest_wakeup_s() -> float:
    from navigation.run.devices.wakeups import Wakeups

    wakeups = Wakeups(time.monotonic)
    wakeups.start()
    time.sleep(WAKEUPS_SEEN_S)  # the thread looks meanwhile
    wakeups.stop()
    return wakeups.worst_s()


def _is_synchronised() -> bool | None:
    program = shutil.which("timedatectl")
    if program is None:
        return None
    try:
        told = subprocess.run(
            [program, "show", "-p", "NTPSynchronized", "--value"],
            capture_output=True, text=True, timeout=5, check=False,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired):
        return None
    return {"yes": True, "no": False}.get(told.stdout.strip())
