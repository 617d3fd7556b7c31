"""The service: what systemd is told and when, the unit, the udev rule, reload and roll-back."""

from __future__ import annotations

import os
import re
import select
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from navigation.cli.run import load_or_go_back
from navigation.config import Config, load_config
from navigation.config.errors import ConfigError
from navigation.config.last_good import LastGood, state_folder
from navigation.machine.logs import EventLog
from navigation.machine.sd_notify import Notifier, Watchdog, watchdog_period_s
from navigation.machine.service import ServiceError, UsbAdapter, udev_text, unit_text
from navigation.run.reload import Reloader
from tests.support.pictures import call
from tests.support.waiting import wait_until

CONFIGS = Path(__file__).parents[3] / "configs"
PROGRAM = Path(sys.executable).parent / "clearway"


@pytest.fixture
def systemd(tmp_path: Path) -> Iterator[socket.socket]:
    """The far end of the notification socket."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as end:
        end.bind(str(tmp_path / "notify"))
        end.settimeout(5.0)
        yield end


@pytest.fixture
def notifier(tmp_path: Path, systemd: socket.socket) -> Iterator[Notifier]:
    notifier = Notifier.from_environment({"NOTIFY_SOCKET": str(tmp_path / "notify")})
    yield notifier
    notifier.close()


def told(end: socket.socket) -> list[str]:
    """Everything that was sent so far."""
    lines = []
    while select.select([end], [], [], 0.0)[0]:
        lines += end.recv(4096).decode().splitlines()
    return lines


# What systemd is told.


def test_a_message_is_one_datagram_of_assignments(
    notifier: Notifier, systemd: socket.socket
) -> None:
    assert notifier.send("READY=1", "STATUS=driving")
    assert systemd.recv(4096) == b"READY=1\nSTATUS=driving"


def test_without_systemd_nothing_is_sent_and_nothing_fails() -> None:
    notifier = Notifier.from_environment({})
    assert notifier.send("READY=1")
    assert notifier.lost == 0


def test_a_socket_in_the_abstract_namespace_is_reached() -> None:
    name = f"clearway-test-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as end:
        end.bind("\0" + name)
        end.settimeout(5.0)
        notifier = Notifier(f"@{name}")
        assert notifier.send("READY=1")
        notifier.close()
        assert end.recv(64) == b"READY=1"


def test_a_full_socket_loses_messages_and_never_waits(
    notifier: Notifier, systemd: socket.socket
) -> None:
    sent = [notifier.send("STATUS=" + "x" * 1000) for _ in range(2000)]
    assert sent[0]
    assert not sent[-1]
    assert notifier.lost == sent.count(False)


def test_a_systemd_that_is_gone_costs_messages_only(tmp_path: Path) -> None:
    notifier = Notifier(str(tmp_path / "nobody"))
    assert not notifier.send("READY=1")
    notifier.close()


# The watchdog.


class Stages:
    """Counters that a test lets turn."""

    def __init__(self) -> None:
        self.turns = {"camera": 0, "planner": 0, "link": 0}

    def turn(self, *names: str) -> None:
        for name in names or self.turns:
            self.turns[name] += 1


def test_the_watchdog_is_fed_four_times_a_period_while_every_stage_turns(
    notifier: Notifier, systemd: socket.socket
) -> None:
    stages = Stages()
    watchdog = Watchdog(notifier, 8.0, lambda: stages.turns)
    lines = []
    for quarter in range(4 * 40 + 1):
        stages.turn()
        watchdog.tick(quarter / 4.0)
        lines += told(systemd)
    assert lines == ["WATCHDOG=1"] * 20
    assert watchdog.hanging == ()


@pytest.mark.parametrize("stuck", ["camera", "planner", "link"])
def test_one_stage_that_hangs_is_enough_and_is_named(
    notifier: Notifier, systemd: socket.socket, stuck: str
) -> None:
    stages = Stages()
    watchdog = Watchdog(notifier, 8.0, lambda: stages.turns)
    others = [name for name in stages.turns if name != stuck]
    for tenth in range(200):
        stages.turn(*others)
        watchdog.tick(tenth / 10.0)
    assert told(systemd) == [f"STATUS=does not get on: {stuck}"]
    assert watchdog.hanging == (stuck,)
    stages.turn()
    watchdog.tick(30.0)
    assert told(systemd) == ["WATCHDOG=1"]
    assert watchdog.hanging == ()


def test_a_stage_that_is_slow_once_is_not_called_hanging(
    notifier: Notifier, systemd: socket.socket
) -> None:
    stages = Stages()
    watchdog = Watchdog(notifier, 8.0, lambda: stages.turns)
    for tenth in range(35):
        stages.turn("camera", "link")
        watchdog.tick(tenth / 10.0)
    stages.turn()
    watchdog.tick(3.5)
    assert told(systemd) == ["WATCHDOG=1"]


def test_no_watchdog_without_a_period(notifier: Notifier, systemd: socket.socket) -> None:
    watchdog = Watchdog(notifier, None, lambda: {"camera": 0})
    watchdog.tick(1e9)
    assert told(systemd) == []


@pytest.mark.parametrize(
    ("environment", "period_s"),
    [
        ({"WATCHDOG_USEC": "40000000"}, 40.0),
        ({"WATCHDOG_USEC": "40000000", "WATCHDOG_PID": "7"}, 40.0),
        ({"WATCHDOG_USEC": "40000000", "WATCHDOG_PID": "8"}, None),
        ({"WATCHDOG_USEC": "soon"}, None),
        ({"WATCHDOG_USEC": "0"}, None),
        ({}, None),
    ],
)
def test_the_period_is_systemd_s_for_this_process(
    environment: dict[str, str], period_s: float | None
) -> None:
    assert watchdog_period_s(environment, own_pid=7) == period_s


# A run as a service, from its start to its stop.


def test_a_service_says_ready_lives_reads_a_broken_file_and_stops(
    tmp_path: Path, systemd: socket.socket
) -> None:
    shutil.copytree(CONFIGS, tmp_path / "etc")
    config = tmp_path / "etc" / "simulation.yaml"
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
        subprocess.Popen(
            [str(PROGRAM), *arguments],
            cwd=tmp_path, env=environment, stderr=err, stdout=subprocess.DEVNULL,
        ) as process,
    ):  # fmt: skip
        seen: list[str] = []

        def is_ready() -> bool:
            seen.extend(told(systemd))
            return bool(seen) or process.poll() is not None

        assert wait_until(is_ready, 200.0)
        assert seen[:1] == ["READY=1"], log.read_text()

        def is_driving_and_fed() -> bool:
            seen.extend(told(systemd))
            return "WATCHDOG=1" in seen and any(line.startswith("STATUS=driv") for line in seen)

        assert wait_until(is_driving_and_fed, 60.0), seen
        config.write_text(config.read_text().replace("radius_m: 0.09", "radius_m: -1"))
        process.send_signal(signal.SIGHUP)
        assert wait_until(lambda: "must be > 0, not -1" in log.read_text(), 30.0)
        assert process.poll() is None, "the run goes on"
        process.send_signal(signal.SIGTERM)
        assert process.wait(20.0) == 0, "an ordered end is no failure"
    assert "STOPPING=1" in told(systemd)
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
    with pytest.raises(ServiceError, match="cannot stand in a udev rule"):
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


# The last good configuration.


@pytest.fixture
def config_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copytree(CONFIGS, tmp_path / "etc")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.delenv("STATE_DIRECTORY", raising=False)
    return tmp_path / "etc" / "simulation.yaml"


def quiet() -> EventLog:
    return EventLog(sys.stderr, None, now=lambda: pytest.fail("nothing is logged"))


def break_file(file: Path) -> None:
    file.write_text(file.read_text().replace("speed_m_s: 0.3", "speed_m_s: fast"))


def test_a_broken_file_is_refused_and_the_last_good_one_is_offered_with_the_change(
    config_file: Path,
) -> None:
    good = load_or_go_back(config_file, False, quiet())
    assert good.robot.speed_m_s == 0.3
    break_file(config_file)
    refused = call("run", config_file)
    assert refused.code == 78
    assert "must be a number, not 'fast'" in refused.err
    assert f"clearway run --last-good {config_file}" in refused.err
    assert "-  speed_m_s: 0.3" in refused.err
    assert "+  speed_m_s: fast" in refused.err


def test_the_last_good_one_is_run_when_asked_for_and_that_is_said(
    config_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good = load_or_go_back(config_file, False, quiet())
    break_file(config_file)
    again = load_or_go_back(config_file, True, quiet())
    assert again == good
    said = capsys.readouterr().err
    assert "must be a number, not 'fast'" in said
    assert "running" in said


def test_a_file_that_never_was_good_has_nothing_to_go_back_to(config_file: Path) -> None:
    break_file(config_file)
    with pytest.raises(ConfigError) as caught:
        load_or_go_back(config_file, True, quiet())
    assert "last good" not in str(caught.value)


def test_each_file_has_a_last_good_one_of_its_own(config_file: Path, tmp_path: Path) -> None:
    other = config_file.with_name("tour.yaml")
    load_or_go_back(config_file, False, quiet())
    assert LastGood(config_file, state_folder(os.environ)).advice() is not None
    assert LastGood(other, state_folder(os.environ)).advice() is None


def test_a_state_folder_that_cannot_be_written_to_costs_the_roll_back_only(
    config_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "taken").write_text("a file")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "taken"))
    assert load_or_go_back(config_file, False, quiet()).robot.speed_m_s == 0.3


def test_the_state_folder_is_systemd_s_xdg_s_or_the_home_s() -> None:
    assert state_folder({"STATE_DIRECTORY": "/var/lib/clearway"}) == Path("/var/lib/clearway")
    assert state_folder({"XDG_STATE_HOME": "/s"}) == Path("/s/clearway")
    assert state_folder({"HOME": "/home/me"}) == Path("/home/me/.local/state/clearway")


# Reading again.


class Heard:
    """A reloader of one file, and what it told."""

    def __init__(self, file: Path) -> None:
        self.said: list[tuple[str, str]] = []
        self.fresh: list[Config] = []
        self.reloader = Reloader(
            file,
            load_config(file, {}),
            load=lambda path: load_config(path, {}),
            say=lambda level, sentence: self.said.append((level, sentence)),
            good=self.fresh.append,
        )

    def ask(self) -> None:
        self.reloader.ask()
        self.reloader.join(20.0)


def test_a_changed_file_is_handed_over_with_the_sections_that_changed(config_file: Path) -> None:
    heard = Heard(config_file)
    text = config_file.read_text()
    config_file.write_text(text.replace("margin_m: 0.015", "margin_m: 0.02"))
    heard.ask()
    assert [config.planning.margin_m for config in heard.fresh] == [0.02]
    assert "planning changed" in heard.said[0][1]


def test_a_broken_file_changes_nothing_and_every_error_is_told(config_file: Path) -> None:
    heard = Heard(config_file)
    break_file(config_file)
    heard.ask()
    ((level, sentence),) = heard.said
    assert level == "error"
    assert "goes on with the last good configuration" in sentence
    assert "must be a number" in sentence
    assert heard.fresh == []


def test_an_unchanged_file_is_read_and_nothing_happens(config_file: Path) -> None:
    heard = Heard(config_file)
    heard.ask()
    assert "nothing has changed" in heard.said[0][1]
    assert heard.fresh == []
