"""The dashboard of `clearway run`: said, left out on request, and never in the run's way."""

import re
import shutil
import socket
from pathlib import Path

import pytest

from tests.support.pictures import Told, call

CONFIGS = Path(__file__).parents[3] / "configs"


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """The shipped simulation without a mission: with --once it ends after a cycle."""
    shutil.copytree(CONFIGS, tmp_path, dirs_exist_ok=True)
    text = (CONFIGS / "simulation.yaml").read_text()
    text = re.sub(r"^mission:\n(?:  .*\n)+", "", text, flags=re.MULTILINE)
    file = tmp_path / "empty.yaml"
    file.write_text(text.replace("runs_dir: runs", f"runs_dir: {tmp_path / 'runs'}"))
    return file


def run(config: Path, *options: str) -> Told:
    return call("run", config, "--once", "--socket", config.parent / "run" / "c.sock", *options)


def test_a_run_says_where_its_dashboard_is(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CLEARWAY_DASHBOARD__PORT", "0")
    told = run(config)
    link = r"^dashboard at http://127\.0\.0\.1:\d+/#token=([\w-]{32})$"
    found = re.search(link, told.out, re.MULTILINE)
    assert found, told
    assert told.err == ""
    kept = config.parent / "run" / "c.sock.token"
    assert kept.read_text().strip() == found[1]
    assert kept.stat().st_mode & 0o777 == 0o600
    assert found[1] in run(config).out, "the link survives a restart"


def test_the_journal_does_not_get_the_programs_own_token(
    config: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CLEARWAY_DASHBOARD__PORT", "0")
    monkeypatch.setenv("JOURNAL_STREAM", "8:1")
    told = run(config)
    assert re.search(r"^dashboard at http://127\.0\.0\.1:\d+/$", told.out, re.MULTILINE), told
    assert (config.parent / "run" / "c.sock.token").read_text().strip() not in told.out


def test_a_token_that_cannot_be_kept_holds_for_one_run_and_that_is_said(
    config: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CLEARWAY_DASHBOARD__PORT", "0")
    (config.parent / "run" / "c.sock.token").mkdir(parents=True)
    (config.parent / "run").chmod(0o700)
    told = run(config)
    assert "the page's token holds for this run only" in told.out
    assert "#token=" in told.out


def test_a_log_does_not_get_the_token(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CLEARWAY_DASHBOARD__PORT", "0")
    monkeypatch.setenv("CLEARWAY_DASHBOARD__TOKEN", "a-token-of-some-length")
    told = run(config)
    assert "dashboard at" in told.out
    assert "a-token-of-some-length" not in told.out + told.err


@pytest.mark.parametrize("way", ["option", "configuration"])
def test_a_run_without_a_dashboard_serves_none(
    way: str, config: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = ["--no-dashboard"] if way == "option" else []
    if way == "configuration":
        monkeypatch.setenv("CLEARWAY_DASHBOARD__ENABLED", "false")
    told = run(config, *options)
    assert "orders at" in told.out
    assert "dashboard at" not in told.out


def test_a_busy_port_does_not_end_a_run(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        monkeypatch.setenv("CLEARWAY_DASHBOARD__PORT", str(taken.getsockname()[1]))
        told = run(config)
    assert "no dashboard: 127.0.0.1:" in told.out
    assert "picture to command" in told.out, "the run went on to its report"


def test_an_open_dashboard_without_a_token_is_a_bad_configuration(
    config: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CLEARWAY_DASHBOARD__HOST", "0.0.0.0")
    told = run(config)
    assert told.code == 78
    assert "needs dashboard.token" in told.err
