"""A run that begins again with changed settings drives nowhere before somebody orders it to."""

from __future__ import annotations

import shutil
from datetime import datetime
from pathlib import Path

import pytest

from navigation.cli.running.run import _Reload
from navigation.config import Config, load_config
from navigation.machine.logs import EventLog
from navigation.run.runner import Runner
from tests.support.waiting import wait_until

CONFIGS = Path(__file__).parents[3] / "configs"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    shutil.copytree(CONFIGS, tmp_path, dirs_exist_ok=True)
    return tmp_path / "simulation.yaml"


def runner_of(config: Config, folder: Path) -> Runner:
    return Runner(
        config.model_copy(
            update={"recording": config.recording.model_copy(update={"runs_dir": folder / "runs"})}
        ),
        once=True,
        say=lambda _line: None,
        socket=folder / "socket",
        dashboard=False,
    )


def test_a_run_that_waits_does_not_drive_the_configured_mission(file: Path) -> None:
    config = load_config(file, {})
    assert config.mission.stations
    runner = runner_of(config, file.parent)
    runner.waits = True
    report = runner.run().report
    assert report.waypoints_sent == 0
    assert report.state != "done"


def test_only_what_the_page_asked_for_waits(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config = load_config(file, {})
    runner = runner_of(config, file.parent)
    with (file.parent / "log").open("w") as out:
        reload = _Reload(file, config, runner, EventLog(out, None, now=datetime.now))
        file.write_text(file.read_text().replace("  rate_hz: 30\n", "  rate_hz: 25\n"))
        reload.ask_from_the_page()
        assert wait_until(lambda: runner.interrupt.is_set())
        assert (reload.from_the_page, reload.fresh is not None) == (True, True)
        reload.ask()
        reload.reloader.join(10.0)
        assert not reload.from_the_page
    assert "camera changed" in capsys.readouterr().err
