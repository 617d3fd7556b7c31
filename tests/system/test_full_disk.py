"""What cannot be written is said, and the mission is driven to its end all the same."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from subprocess import PIPE
from typing import IO

import pytest

from navigation.config import load_config
from navigation.journal.journal import Journal, Owner
from navigation.run.kernels.warm_up import warm_up
from tests.support.processes.forked import Program
from tests.support.runs.light_camera import with_light_camera

CONFIGS = Path(__file__).parents[2] / "configs"
PROGRAM = [sys.executable, "-c", "from navigation.cli.main import main; main()"]
MISSION = "mission:\n  stations:\n    - {x_m: 0.20, y_m: 0.60}\n"
LIMITED = """
import resource, sys
from navigation.cli.main import main
sys.dont_write_bytecode = True  # what is cut off by the limit would stay, and break later starts
resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200))
main()
"""
DONE = re.compile(r"(?m)^  state +done: ")


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """A short mission with a journal and a recording, in a folder of its own."""
    shutil.copytree(CONFIGS, tmp_path / "etc")
    file = tmp_path / "etc" / "simulation.yaml"
    text = with_light_camera(file.read_text())
    text = re.sub(r"^mission:\n(?:  .*\n)+", MISSION, text, flags=re.MULTILINE)
    file.write_text(
        text.replace("runs_dir: runs", f"runs_dir: {tmp_path / 'runs'}")
        + f"  journal: {tmp_path / 'runs' / 'journal'}\n"
    )
    warm_up(load_config(file, {}), print)
    return file


def start(
    config: Path, *more: str, file: Path | None = None, stdout: int | IO[str] = PIPE
) -> Program:
    state = {"XDG_STATE_HOME": str(config.parent / "state")}
    return Program(
        words(config, *more), file=file, env={**os.environ, **state}, stdout=stdout, stderr=PIPE
    )


def words(config: Path, *more: str) -> list[str]:
    socket = config.parent / "c.sock"
    return ["run", str(config), "--once", "--no-dashboard", "--socket", str(socket), *more]


def finish(run: subprocess.Popen[str] | Program) -> tuple[int, str, str]:
    with run:
        out, err = run.communicate(timeout=120)
    assert run.returncode is not None
    return run.returncode, out or "", err


def test_a_full_stdout_costs_its_lines_and_the_summary_comes_on_stderr(config: Path) -> None:
    with Path("/dev/full").open("w") as full:
        code, _, err = finish(start(config, stdout=full))
    assert code == 0, err
    assert "stdout cannot be written: No space left on device; the run continues" in err
    assert err.count("stdout cannot be written") == 1
    assert DONE.search(err), err
    assert "Traceback" not in err


def test_a_closed_stdout_ends_no_mission(config: Path) -> None:
    environment = {**os.environ, "XDG_STATE_HOME": str(config.parent / "state")}
    run = subprocess.Popen(
        [*PROGRAM, *words(config)],
        env=environment, stderr=PIPE, text=True, preexec_fn=lambda: os.close(1),
    )  # fmt: skip
    code, _, err = finish(run)
    assert code == 0, err
    assert DONE.search(err), err


def test_a_reader_that_goes_away_ends_no_mission(config: Path) -> None:
    run = start(config)
    assert run.stdout is not None
    run.stdout.readline()
    run.stdout.close()
    run.stdout = None
    code, _, err = finish(run)
    assert code == 0, err
    assert "stdout cannot be written: Broken pipe" in err
    assert DONE.search(err), err


def test_files_that_may_not_grow_end_no_mission(config: Path, tmp_path: Path) -> None:
    """As on a full disk: the log, the journal, the recording, the report and the picture."""
    limited = tmp_path / "limited.py"
    limited.write_text(LIMITED)
    record = ("--record", str(tmp_path / "recordings"))
    report = ("--report", str(tmp_path / "report.json"))
    code, out, err = finish(start(config, *record, *report, file=limited))
    assert code == 0, out + err
    assert DONE.search(out), out
    for name in ("events.jsonl", "report.json", "track.svg", "journal", "recording"):
        assert re.search(rf"(?m)^.*{re.escape(name)}.*$", out), f"{name}: {out}"
    assert "Traceback" not in err
    assert f"{tmp_path / 'report.json'}: cannot be written: File too large" in err
    left = [file for file in tmp_path.rglob("*.json") if "etc" not in file.parts]
    assert left == [], "no half report"


def test_a_journal_that_is_deleted_on_the_way_is_said_and_made_again(
    config: Path, tmp_path: Path
) -> None:
    run = start(config)
    assert run.stdout is not None
    said = []
    for line in run.stdout:
        said.append(line)
        if "driving" in line:
            break
    for file in (tmp_path / "runs").glob("journal*"):
        file.unlink()
    code, out, err = finish(run)
    assert code == 0, err
    told = "".join(said) + out
    assert f"journal {tmp_path / 'runs' / 'journal'}: was deleted" in told, told
    assert DONE.search(told), told
    events = [
        json.loads(line)
        for file in (tmp_path / "runs").glob("*/events.jsonl")
        for line in file.read_text().splitlines()
    ]
    assert any(e["event"] == "trouble" and "was deleted" in e["reason"] for e in events)


def test_a_second_run_with_the_same_journal_is_refused(config: Path) -> None:
    with Journal(config.parent.parent / "runs" / "journal", Owner()):
        code, out, err = finish(start(config))
    assert (code, out) == (2, "")
    assert re.fullmatch(r"clearway: error: journal .*: is in use by another program, .*\n", err)
