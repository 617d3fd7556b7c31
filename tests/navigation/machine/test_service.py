"""The service: a run from its start to its stop, the unit, the udev rule."""

from __future__ import annotations

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from navigation.machine.service import ServiceError, UsbAdapter, udev_text, unit_text
from tests.support.pictures import call
from tests.support.processes.forked import Program
from tests.support.processes.systemd import messages_to
from tests.support.runs.light_camera import with_light_camera
from tests.support.waiting import wait_until

CONFIGS = Path(__file__).parents[3] / "configs"
PROGRAM = Path(sys.executable).parent / "clearway"


def test_a_service_says_ready_lives_reads_a_broken_file_and_stops(
    tmp_path: Path, systemd: socket.socket
) -> None:
    shutil.copytree(CONFIGS, tmp_path / "etc")
    config = tmp_path / "etc" / "simulation.yaml"
    config.write_text(with_light_camera(config.read_text()))
    log = tmp_path / "log"
    environment = {
        **os.environ,
        "NOTIFY_SOCKET": str(tmp_path / "notify"),
        "WATCHDOG_USEC": "4000000",
        "XDG_STATE_HOME": str(tmp_path / "state"),
    }
    arguments = ["run", str(config), "--quiet", "--no-dashboard", "--log-format", "json"]
    arguments += ["--socket", str(tmp_path / "private" / "socket")]
    with (
        log.open("w") as err,
        Program(
            arguments, cwd=tmp_path, env=environment, stderr=err, stdout=subprocess.DEVNULL
        ) as process,
    ):
        seen: list[str] = []

        def is_ready() -> bool:
            seen.extend(messages_to(systemd))
            return bool(seen) or process.poll() is not None

        assert wait_until(is_ready, 200.0)
        assert seen[:1] == ["READY=1"], log.read_text()

        def is_driving_and_fed() -> bool:
            seen.extend(messages_to(systemd))
            return "WATCHDOG=1" in seen and any(line.startswith("STATUS=driv") for line in seen)

        assert wait_until(is_driving_and_fed, 60.0), seen
        config.write_text(config.read_text().replace("radius_m: 0.09", "radius_m: -1"))
        process.send_signal(signal.SIGHUP)
        assert wait_until(lambda: "must be > 0, not -1" in log.read_text(), 30.0)
        assert process.poll() is None, "the run goes on"
        process.send_signal(signal.SIGTERM)
        assert process.wait(20.0) == 0, "an ordered end is no failure"
    assert "STOPPING=1" in messages_to(systemd)
    events = re.findall(r'"event": "(\w+)"', log.read_text())
    assert events[:2] == ["started", "ready"]
    assert events[-1] == "finished"


# The unit and the rule.


@pytest.mark.parametrize("user", [True, False])
@pytest.mark.parametrize("name", ["arena.yaml", "my arena 100%.yaml"])
def test_systemd_itself_finds_no_fault_in_the_unit(tmp_path: Path, user: bool, name: str) -> None:
    analyze = shutil.which("systemd-analyze")
    if analyze is None:
        pytest.skip("systemd-analyze is not installed")
    unit = tmp_path / "clearway.service"
    unit.write_text(unit_text(PROGRAM, tmp_path / name, user=user))
    checked = subprocess.run(
        [analyze, "verify", str(unit)], capture_output=True, text=True, check=False
    )
    assert (checked.returncode, checked.stderr) == (0, "")


def test_the_unit_says_what_the_daemon_relies_on() -> None:
    lines = unit_text(PROGRAM, Path("/etc/clearway.yaml"), user=False).splitlines()
    for line in (
        "Type=notify",
        "WatchdogSec=40",
        "Restart=on-failure",
        "RestartPreventExitStatus=78",
        "CacheDirectory=clearway",
        "StateDirectory=clearway",
        "ProtectSystem=strict",
        "NoNewPrivileges=yes",
        "DynamicUser=yes",
        "WantedBy=multi-user.target",
    ):
        assert line in lines
    assert not any(line.startswith("MemoryDenyWriteExecute") for line in lines), "kernels need it"


def test_a_user_s_unit_asks_for_nothing_that_needs_root() -> None:
    text = unit_text(PROGRAM, Path("/home/me/arena.yaml"), user=True)
    for word in ("User=", "SupplementaryGroups", "DeviceAllow", "ProtectSystem"):
        assert word not in text
    assert "WantedBy=default.target" in text


def test_a_unit_needs_absolute_paths_and_a_real_account() -> None:
    with pytest.raises(ServiceError, match="absolute"):
        unit_text(PROGRAM, Path("arena.yaml"), user=True)
    with pytest.raises(ServiceError, match="no name of an account"):
        unit_text(PROGRAM, Path("/a.yaml"), user=False, run_as="me\nExecStartPre=/bin/sh")
    with pytest.raises(ServiceError, match="control characters"):
        unit_text(PROGRAM, Path("/a\nb.yaml"), user=False)


def test_the_rule_names_the_adapter_and_keeps_modem_manager_away() -> None:
    rule = udev_text(UsbAdapter("1a86", "7523", "A50285BI")).splitlines()[1]
    assert 'ATTRS{idVendor}=="1a86"' in rule
    assert 'ATTRS{serial}=="A50285BI"' in rule
    assert 'SYMLINK+="clearway-robot"' in rule
    assert 'ENV{ID_MM_DEVICE_IGNORE}="1"' in rule
    assert "serial" not in udev_text(UsbAdapter("1a86", "7523")).splitlines()[1]


def test_a_serial_number_cannot_break_out_of_the_rule() -> None:
    with pytest.raises(ServiceError, match="cannot be in a udev rule"):
        udev_text(UsbAdapter("1a86", "7523", 'x", RUN+="/bin/sh'))


def test_install_service_writes_below_a_root_or_prints(tmp_path: Path) -> None:
    config = CONFIGS / "simulation.yaml"
    printed = call("install-service", config, "--print")
    assert printed.code == 0
    assert "[Service]" in printed.out
    installed = call("install-service", config, "--root", tmp_path, "--run-as", "robot")
    assert installed.code == 0, installed
    unit = tmp_path / "etc" / "systemd" / "system" / "clearway.service"
    assert "User=robot" in unit.read_text()
    assert f"run {config.resolve()}" in unit.read_text()
    assert "enable --now clearway" in installed.out


def test_a_user_s_service_goes_where_the_user_s_manager_looks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    installed = call("install-service", CONFIGS / "simulation.yaml", "--user")
    assert installed.code == 0, installed
    unit = tmp_path / "systemd" / "user" / "clearway.service"
    assert "WantedBy=default.target" in unit.read_text()
    assert "systemctl --user daemon-reload" in installed.out


def test_install_service_refuses_a_broken_configuration(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("arena: 1\n")
    refused = call("install-service", tmp_path / "a.yaml", "--root", tmp_path)
    assert refused.code == 78
    assert list(tmp_path.rglob("*.service")) == []
