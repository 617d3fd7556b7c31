"""One of two cameras is knocked while the robot drives, in virtual time; ground truth decides."""

from __future__ import annotations

import math
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from navigation.config import Config
from navigation.config.several.each_camera import each_camera
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.run.anchoring import AnchoringError, of_camera, renew
from navigation.simulator.picture.pinhole import pinhole_of
from tests.support.runs.two_cameras import Stage, config_of
from tests.support.runs.virtual import cycle_until
from vision.calibration.calibration_file import load_calibration, save_calibration

pytestmark = pytest.mark.slow

GOAL = (2.2, 1.6)
KNOCK_S = 3.0
MARKERS = [
    {"marker_id": 20 + i, "size_m": 0.12, "place_m": (x, y), "heading_deg": 90.0 * i}
    for i, (x, y) in enumerate((x, y) for x in (-0.25, 2.65) for y in (0.3, 0.9, 1.5))
]
"""Three that only the left camera shows, three that only the right one shows."""
TILT_DEG = math.degrees(math.atan(3.0 / 617.5))
"""3 px."""


def knocked(name: str, markers: bool = True, **knock: Any) -> Config:
    return config_of(
        GOAL,
        start=(0.72, 1.52),
        cameras={name: {"knocks": [knock]}},
        arena={"floor_markers": MARKERS if markers else []},
    )


@pytest.mark.parametrize(("name", "markers"), [("left", True), ("right", True), ("right", False)])
def test_a_knock_of_either_camera_holds_the_robot_until_it_is_back(
    name: str, markers: bool
) -> None:
    back_s = KNOCK_S + 4.0
    config = knocked(name, markers, from_s=KNOCK_S, until_s=back_s, tilt_deg=(TILT_DEG, 0.0))
    stage = Stage(config)
    with stage.daemon:
        stage.set_off()
        held = cycle_until(
            stage.daemon, lambda now: f"camera {name} has moved: " in now.sentence, each=stage.watch
        )
        assert held.mission.state is State.HOLDING
        assert KNOCK_S < stage.world.clock() < KNOCK_S + 1.0
        assert (
            f"put the camera back, or renew its anchoring by clearway reanchor --camera {name}"
            in held.sentence
        )
        other = "right" if name == "left" else "left"
        assert f"camera {other}" not in " ".join(stage.troubles)
        cycle_until(stage.daemon, lambda now: not now.link.moving)
        stage.daemon.people.resume()
        here = stage.where()
        stage.wait(back_s - 0.2 - stage.world.clock())
        assert math.dist(here, stage.where()) < 0.001, "it stands, whoever resumes"
        done = stage.until(State.DONE, State.FAILED, State.STOPPED)
        assert done.mission.state is State.DONE, done.sentence
        assert stage.world.clock() > back_s
        assert done.troubles == ()
        assert stage.clearance_m() > 0.0


def test_two_cameras_that_hang_still_say_nothing() -> None:
    stage = Stage(config_of(GOAL, start=(0.72, 1.52), arena={"floor_markers": MARKERS}))
    with stage.daemon:
        stage.set_off()
        assert stage.until(State.DONE, State.FAILED, State.STOPPED).mission.state is State.DONE
        assert stage.troubles == []


def test_one_that_was_knocked_before_the_run_never_lets_the_robot_drive() -> None:
    stage = Stage(knocked("right", from_s=0.0, tilt_deg=(2 * TILT_DEG, 0.0)))
    with stage.daemon:
        start = stage.where()
        stage.daemon.people.give(stations_of(stage.daemon.config))
        now = stage.wait(5.0)
        assert "camera right has moved" in now.sentence
        assert "since before the run" in now.sentence
        assert math.dist(start, stage.where()) < 0.02


def test_the_anchoring_of_one_is_renewed_and_the_others_stays(tmp_path: Path) -> None:
    config = knocked("right", from_s=0.0, tilt_deg=(0.2, -0.2), turn_deg=0.5)
    files = {name: tmp_path / f"{name}.yaml" for name in ("left", "right")}
    for name, one in each_camera(config).items():
        save_calibration(pinhole_of(one).calibration(), files[name])
    cameras = [{"name": name, "calibration": file} for name, file in files.items()]
    config = Config.model_validate({**config.model_dump(), "cameras": cameras})
    before = {name: file.read_text() for name, file in files.items()}
    stage = Stage(config)
    with stage.daemon:
        stage.daemon.people.give(stations_of(config))
        held = cycle_until(stage.daemon, lambda now: "camera right has moved" in now.sentence)
        assert held.mission.state is not State.DRIVING
        frame = stage.daemon.newest("right")
        assert frame is not None
        assert frame.image.shape == (480, 640)
        assert stage.daemon.newest(None) is None, "one of several has to be named"
        renew(of_camera(config, "right"), [frame.image], datetime(2026, 1, 2, 3, 4, 5))
    assert files["left"].read_text() == before["left"]
    right = each_camera(config)["right"]
    assert right.simulation is not None
    truth = pinhole_of(right, right.simulation.camera.knocks[0]).calibration()
    places = [(1.0, 0.2), (2.2, 0.2), (2.2, 1.6), (1.0, 1.6)]
    found = load_calibration(files["right"])
    assert abs(found.arena_from_image(truth.image_from_arena(places)) - places).max() < 0.002


@pytest.mark.parametrize(
    ("name", "sentence"), [(None, "say which one"), ("back", "there is left, right")]
)
def test_of_several_cameras_one_has_to_be_named(name: str | None, sentence: str) -> None:
    with pytest.raises(AnchoringError, match=sentence):
        of_camera(config_of(GOAL), name)
