"""A run that records is killed, and what it left replays to the same result."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from subprocess import PIPE

from tests.support.pictures import call
from tests.support.processes.forked import Program
from tests.support.runs.light_camera import with_light_camera

CONFIGS = Path(__file__).parents[2] / "configs"


def test_a_recorded_run_that_was_killed_replays_to_the_same_result(tmp_path: Path) -> None:
    shutil.copytree(CONFIGS, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "simulation.yaml"
    file.write_text(with_light_camera(file.read_text()))
    arguments = ["run", "simulation.yaml", "--once", "--record", "kept", "--no-dashboard"]
    arguments += ["--socket", str(tmp_path / "private" / "socket")]
    with Program(arguments, stdout=PIPE, cwd=tmp_path) as process:
        assert process.stdout is not None
        told = []
        for line in process.stdout:
            told.append(line)
            if re.search(r"driving +at .* 1/3", line) or "done" in line:
                break
        process.kill()
    assert any("recording into kept" in line for line in told)
    (file,) = (tmp_path / "kept").glob("*.mcap")
    replayed = call("replay", file, "--format", "json")
    assert replayed.code == 0, replayed
    result = json.loads(replayed.out)
    assert result["cut"]
    assert result["status"] == "equal"
    assert result["poses"] > 20
    assert result["scenes"] >= 1
    assert result["plans"] >= 1
