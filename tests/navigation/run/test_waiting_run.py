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
    assert report.only.waypoints_sent == 0
    assert report.state != "done"


def test_several_robots_that_wait_drive_neither_missions_nor_tasks(file: Path) -> None:
    text = (file.parent / "alcove.yaml").read_text()
    mission = text[text.index("mission:") : text.index("simulation:")]
    some = mission.splitlines(keepends=True)[:3]  # the first robot's
    tasks = "tasks: [{x_m: 0.2, y_m: 0.9}]\n"
    (file.parent / "alcove.yaml").write_text(text.replace(mission, "".join(some) + tasks))
    config = load_config(file.parent / "alcove.yaml", {})
    assert config.tasks
    assert config.mission.robots[0].stations
    runner = runner_of(config, file.parent)
    runner.waits = True
    report = runner.run().report
    assert {name: one.stations for name, one in report.robots.items()} == {"left": 0, "right": 0}
    assert sum(one.waypoints_sent for one in report.robots.values()) == 0


@pytest.mark.parametrize(
    ("asked", "waits"),
    [
        (["page"], True),
        (["HUP"], False),
        (["page", "HUP"], True),
        (["HUP", "page"], True),
        (["page", "HUP", "HUP"], True),
    ],
    ids=["page", "HUP", "page then HUP", "HUP then page", "page then HUP twice"],
)
def test_settings_of_the_page_wait_for_orders_whatever_asks_at_the_same_time(
    file: Path, asked: list[str], waits: bool
) -> None:
    runner = runner_of(load_config(file, {}), file.parent)
    with (file.parent / "log").open("w") as out:
        log = EventLog(out, None, now=datetime.now)
        reload = _Reload(file, runner.config, runner, log)
        file.write_text(file.read_text().replace("  rate_hz: 30\n", "  rate_hz: 25\n"))
        for who in asked:
            (reload.ask_from_the_page if who == "page" else reload.ask)()
        assert wait_until(lambda: runner.interrupt.is_set())
        reload.reloader.join(10.0)
    assert reload.fresh is not None
    assert reload.reloader.waits is waits


def test_settings_of_the_page_wait_though_a_signal_had_the_new_file_read_first(
    file: Path,
) -> None:
    runner = runner_of(load_config(file, {}), file.parent)
    with (file.parent / "log").open("w") as out:
        log = EventLog(out, None, now=datetime.now)
        reload = _Reload(file, runner.config, runner, log)
        file.write_text(file.read_text().replace("  rate_hz: 30\n", "  rate_hz: 25\n"))
        reload.ask()
        reload.reloader.join(10.0)
        assert not reload.reloader.waits
        reload.ask_from_the_page()
        reload.reloader.join(10.0)
    assert reload.reloader.waits


def test_a_page_that_has_changed_nothing_holds_back_no_later_signal(file: Path) -> None:
    runner = runner_of(load_config(file, {}), file.parent)
    with (file.parent / "log").open("w") as out:
        log = EventLog(out, None, now=datetime.now)
        reload = _Reload(file, load_config(file, {}), runner, log)
        reload.ask_from_the_page()
        reload.reloader.join(10.0)
        file.write_text(file.read_text().replace("  rate_hz: 30\n", "  rate_hz: 25\n"))
        reload.ask()
        reload.reloader.join(10.0)
    assert reload.fresh is not None
    assert not reload.reloader.waits
