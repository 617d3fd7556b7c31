"""A run that is stopped says the cause: on the terminal, in log and report, and by a call."""

from __future__ import annotations

import shutil
import threading
from datetime import datetime
from pathlib import Path

import pytest

from navigation.config import load_config
from navigation.config.notify import NotifySection
from navigation.config.several.each_robot import robots_of
from navigation.control import ControlServer, send_order
from navigation.journal.stop_latch import read_latches
from navigation.machine.logs import EventLog
from navigation.run.runner import Runner
from tests.support.runs.virtual import short_config
from tests.support.waiting import wait_until

CONFIGS = Path(__file__).parents[3] / "configs"
TOLD = ("{robot}", "{state}", "{sentence}")


@pytest.mark.parametrize(
    "name", ["simulation.yaml", "alcove.yaml"], ids=["one robot", "several robots"]
)
def test_an_emergency_stop_is_said_with_its_cause(name: str, tmp_path: Path) -> None:
    shutil.copytree(CONFIGS, tmp_path, dirs_exist_ok=True)
    config = load_config(tmp_path / name, {})
    tell = ("/bin/sh", "-c", f'echo "$0 $1: $2" >> {tmp_path}/told', *TOLD)
    config = config.model_copy(
        update={
            "recording": config.recording.model_copy(update={"runs_dir": tmp_path / "runs"}),
            "notify": NotifySection(command=tell),
        }
    )
    said: list[str] = []
    reasons: list[str] = []
    with (tmp_path / "log").open("w") as out:
        runner = Runner(
            config, once=False, say=said.append, socket=tmp_path / "socket" / "s", dashboard=False,
            log=EventLog(out, "text", now=datetime.now),
        )  # fmt: skip

        def drive() -> None:
            reasons.append(runner.run().report.reason)

        thread = threading.Thread(target=drive)
        thread.start()
        assert wait_until(lambda: any(" driving " in line for line in said), 60.0)
        send_order(tmp_path / "socket" / "s", {"order": "stop", "reason": "a cat on the table"})
        assert wait_until(
            lambda: any("stopped   a cat on the table" in line for line in said), 1.0
        ), said
        runner.interrupt.set()
        thread.join(30.0)
    assert "a cat on the table; then interrupted" in reasons[0]
    states = [line for line in (tmp_path / "log").read_text().splitlines() if " state " in line]
    assert any(" warning " in line and "a cat on the table" in line for line in states), states
    names = [robot or "robot" for robot in robots_of(config)]
    told = (tmp_path / "told").read_text().splitlines()
    assert sorted(told) == [f"{robot} stopped: a cat on the table" for robot in sorted(names)]


def test_the_last_stop_that_is_taken_holds_the_next_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Orders are taken until the socket is closed, in a reload too."""
    stops, answers = tmp_path / "stops", []
    close = ControlServer.__exit__

    def stop_and_close(control: ControlServer, *error: object) -> None:
        answers.append(send_order(control.path, {"order": "stop", "reason": "at the last moment"}))
        close(control, *error)

    def end_at_once(line: str) -> None:
        if line.startswith("orders at"):
            runner.interrupt.set()

    monkeypatch.setattr(ControlServer, "__exit__", stop_and_close)
    config = short_config([], recording={"runs_dir": tmp_path / "runs"})
    socket = tmp_path / "socket" / "s"
    runner = Runner(
        config, once=False, say=end_at_once, socket=socket, dashboard=False, stops=stops
    )
    runner.run()
    assert answers[0].get("trouble") is None
    (kept,) = read_latches(stops)
    assert "at the last moment" in kept.sentence
