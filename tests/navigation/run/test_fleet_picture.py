"""The picture that a run of several robots leaves behind."""

import re
from pathlib import Path

import numpy as np
import pytest

from navigation.draw import DrawError
from navigation.draw.shapes import ROBOTS
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.run.run_folder import write_picture
from navigation.run.run_report import summarise_run
from navigation.run.runner import Runner
from navigation.run.virtual_run import run_virtually
from tests.support.runs.light_camera import in_small_pictures
from tests.support.runs.virtual import alcove

ALCOVE = alcove()
SECONDS = 4.0
LIMIT_S = 10.0
"""Of a run in real time: too short to arrive, and long enough to set off on a busy computer."""


def test_each_robot_has_its_track_in_its_own_colour_and_the_length_that_it_drove(
    tmp_path: Path,
) -> None:
    file, driven_m = tmp_path / "track.svg", {}

    def look(daemon: Daemon, now: RunState) -> bool:
        if now.time_s < SECONDS:
            return False
        truths = daemon.world.truths
        report = summarise_run(daemon, now.state, now.sentence, now.time_s)
        write_picture(file, daemon, report)
        with pytest.raises(DrawError, match="cannot be written"):
            write_picture(tmp_path / "no" / "track.svg", daemon, report)
        for name, truth in truths.items():
            steps = np.diff(truth.track()[:, 1:3], axis=0)
            driven_m[name] = float(np.hypot(*steps.T).sum())
        return True

    run_virtually(ALCOVE, look=look, pictures=False)
    picture = file.read_text()
    for number, (name, length_m) in enumerate(driven_m.items()):
        assert length_m > 0.2
        colour = "#{:02x}{:02x}{:02x}".format(*ROBOTS[number])
        assert colour in picture
        told = re.search(rf">{number + 1} {name}, ([\d.]+) m<", picture)
        assert told is not None, "the legend has it"
        assert float(told[1]) == pytest.approx(length_m, rel=0.01)
        assert f">{number + 1} {name}<" in picture, "beside the robot"


def test_a_run_leaves_it_beside_its_report(tmp_path: Path) -> None:
    small = in_small_pictures(ALCOVE)
    assert small.simulation is not None
    simulation = small.simulation.model_copy(update={"time_limit_s": LIMIT_S})
    recording = ALCOVE.recording.model_copy(update={"runs_dir": tmp_path, "journal": None})
    config = small.model_copy(update={"simulation": simulation, "recording": recording})
    socket = tmp_path / "socket"
    runner = Runner(config, once=True, say=lambda _: None, socket=socket, dashboard=False)
    result = runner.run()
    report, folder = result.report, result.folder
    assert report.state == "failed", "there was no time to arrive"
    assert folder is not None
    assert {"report.json", "track.svg"} <= {file.name for file in folder.iterdir()}
    picture = (folder / "track.svg").read_text()
    assert ">2 right" in picture
    assert re.search('stroke-width="5(.00)?"', picture), "no track, only the legend"
