"""The last good configuration: offered where the file is broken, and run when asked for."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from navigation.cli.running.run import load_or_go_back
from navigation.config.errors import ConfigError
from navigation.config.last_good import LastGood, state_folder
from navigation.machine.logs import EventLog
from tests.support.broken_config import break_file
from tests.support.pictures import call


def quiet() -> EventLog:
    return EventLog(sys.stderr, None, now=lambda: pytest.fail("nothing is logged"))


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


def test_a_path_that_is_no_utf_8_has_a_copy_too(tmp_path: Path) -> None:
    file = Path(os.fsdecode(b"/arena/caf\xe9.yaml"))
    kept = LastGood(file, tmp_path)
    assert kept.keep("robot: {}\n") is None
    assert LastGood(file, tmp_path).kept.read_text() == "robot: {}\n"
