"""A camera that is knocked while the robot drives, in virtual time; ground truth decides."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from navigation.config import Config
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.mission.mission import MissionError, State
from navigation.run.anchoring import renew, take_over_lens
from navigation.run.virtual_world import VirtualWorld
from navigation.simulator.picture.pinhole import pinhole_of
from tests.support.runs.virtual import cycle_until, is_driving, short_config
from vision.calibrate.lens import Lens
from vision.calibration.calibration_file import load_calibration, save_calibration

GOAL = [{"x_m": 0.20, "y_m": 1.60}]
KNOCK_S = 3.975
"""Just before a picture, from which on the camera is said to have moved."""
HIGH_CAMERA = {
    "position_m": (1.155, 0.975, 2.9), "focal_px": 617.5, "centre_offset_px": (2.6, -1.9)
}  # fmt: skip
MARKERS = [
    {"marker_id": 20 + i, "size_m": 0.12, "place_m": place, "heading_deg": 90.0 * i}
    for i, place in enumerate([(-0.15, -0.13), (2.5, -0.1), (2.45, 1.91), (-0.1, 1.91)])
]
TILT_DEG = math.degrees(math.atan(3.0 / 617.5))
"""3 px."""


def arena(knocks: list[dict[str, Any]], markers: bool = True, **camera: Any) -> Config:
    base = short_config(GOAL, simulation={"camera": {**HIGH_CAMERA, "knocks": knocks}})
    values = base.model_dump()
    values["arena"]["floor_markers"] = MARKERS if markers else []
    values["camera"].update(camera)
    return Config.model_validate(values)


@contextmanager
def driving(
    config: Config, world: VirtualWorld | None = None
) -> Iterator[tuple[VirtualWorld, Daemon]]:
    world = world or VirtualWorld(config)
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        yield world, daemon


@pytest.mark.parametrize("markers", [True, False], ids=["floor markers", "corners"])
@pytest.mark.parametrize(
    "knock", [{"tilt_deg": (TILT_DEG, 0.0)}, {"turn_deg": 1.0}, {"shift_m": (0.0, 0.03, 0.0)}]
)
def test_a_knock_holds_the_robot_within_a_second_until_the_camera_is_back(
    markers: bool, knock: dict[str, Any]
) -> None:
    back_s = KNOCK_S + 4.0
    config = arena([{"from_s": KNOCK_S, "until_s": back_s, **knock}], markers)
    with driving(config) as (world, daemon):
        cycle_until(daemon, is_driving)
        # a robot that jumps in the picture is held at once: its wheels say otherwise
        held = cycle_until(daemon, lambda now: "the camera has moved: " in now.sentence)
        assert held.mission.state is State.HOLDING
        assert KNOCK_S < world.clock() < KNOCK_S + 1.0
        assert f"since {KNOCK_S:.1f} s into the run" in held.sentence
        assert "put the camera back, or renew its anchoring by clearway reanchor" in held.sentence
        assert any(trouble.startswith("the camera has moved: ") for trouble in held.troubles)
        said = []
        cycle_until(daemon, lambda now: not now.link.moving)
        daemon.people.resume()
        here = world.body.pose()[:2]
        until_s = back_s - 0.1
        cycle_until(
            daemon, lambda _: world.clock() > until_s, each=lambda now: said.append(now.sentence)
        )
        assert math.dist(here, world.body.pose()[:2]) < 0.001, "it stands, whoever resumes"
        assert all("the camera has moved: " in sentence for sentence in said)
        done = cycle_until(daemon, lambda now: now.mission.state is State.DONE)
        assert world.clock() > back_s
        assert done.troubles == ()
        track = world.truths[""].track()
        assert world.truths[""].track_clearance(track) > config.robot.radius_m


def test_a_camera_that_was_knocked_before_the_run_never_lets_the_robot_drive() -> None:
    config = arena([{"from_s": 0.0, "tilt_deg": (2 * TILT_DEG, 0.0)}])
    with driving(config) as (world, daemon):
        start = world.body.pose()[:2]
        now = cycle_until(daemon, lambda _: world.clock() > 6.0)
        assert "since before the run" in now.sentence
        assert math.dist(start, world.body.pose()[:2]) < 0.02


def test_a_run_of_a_camera_that_hangs_still_says_nothing() -> None:
    with driving(arena([])) as (_, daemon):
        done = cycle_until(
            daemon,
            lambda now: now.mission.state is State.DONE,
            each=lambda now: pytest.fail(str(now.troubles)) if now.troubles else None,
        )
        assert done.troubles == ()


def test_the_anchoring_is_renewed_from_the_markers_and_a_new_run_drives_by_it(
    tmp_path: Path,
) -> None:
    file = tmp_path / "calibration.yaml"
    config = arena([{"from_s": 0.0, "tilt_deg": (0.2, -0.2), "turn_deg": 0.5}], calibration=file)
    assert config.simulation is not None
    save_calibration(pinhole_of(config).calibration(), file)
    before = file.read_text()
    with driving(config) as (world, daemon):
        held = cycle_until(daemon, lambda now: "the camera has moved" in now.sentence)
        assert held.frame is not None
        renewed = renew(config, [held.frame.image], datetime(2026, 1, 2, 3, 4, 5))
    assert renewed.backup == tmp_path / "calibration.20260102-030405.yaml"
    assert renewed.backup.read_text() == before
    truth = pinhole_of(config, config.simulation.camera.knocks[0])
    found = load_calibration(file)
    places = [(0.2, 0.2), (2.2, 0.2), (2.2, 1.6), (0.2, 1.6), (1.2, 0.9)]
    errors = found.arena_from_image(truth.calibration().image_from_arena(places)) - places
    assert abs(errors).max() < 0.002
    with driving(config) as (world, daemon):
        done = cycle_until(daemon, lambda now: now.mission.state is State.DONE)
        assert done.troubles == ()
        goal = (GOAL[0]["x_m"], GOAL[0]["y_m"])
        assert math.dist(world.body.pose()[:2], goal) < 0.015


def test_a_lens_found_meanwhile_is_placed_by_the_markers_and_a_new_run_drives_by_it(
    tmp_path: Path,
) -> None:
    file = tmp_path / "calibration.yaml"
    config = arena([], calibration=file)
    truth = pinhole_of(config).calibration()
    lens = Lens(truth.size, truth.camera_matrix, truth.distortion, 0.1, 5, (), (), truth.lens_model)
    wrong = truth.camera_matrix.copy()
    wrong[0, 0] = wrong[1, 1] = 1.03 * wrong[0, 0]
    save_calibration(replace(truth, camera_matrix=wrong), file)
    asked: list[None] = []
    with driving(config) as (world, daemon):
        daemon.lent = "the camera is being calibrated from the page"
        here = world.body.pose()[:2]
        held = cycle_until(daemon, lambda now: "being calibrated" in now.sentence)
        assert held.mission.state is State.HOLDING
        cycle_until(daemon, lambda _: world.clock() > 4.0)
        assert math.dist(here, world.body.pose()[:2]) < 0.001, "the robot holds"
        with pytest.raises(MissionError, match="being calibrated"):
            daemon.people.give(stations_of(config))
        frame = cycle_until(daemon, lambda now: now.frame is not None).frame
    assert frame is not None
    now = datetime(2026, 1, 2)
    said = take_over_lens(config, lens, frame.image, now, lambda: asked.append(None))
    assert "the run begins again with it, and waits for orders" in said
    assert asked == [None]
    assert (tmp_path / "calibration.20260102-000000.yaml").exists()
    found = load_calibration(file)
    assert found.camera_matrix[0, 0] == truth.camera_matrix[0, 0]
    places = [(0.2, 0.2), (2.2, 0.2), (2.2, 1.6), (0.2, 1.6), (1.2, 0.9)]
    errors = found.arena_from_image(truth.image_from_arena(places)) - places
    assert abs(errors).max() < 0.002
    with driving(config) as (_, daemon):
        cycle_until(daemon, lambda now: now.mission.state is State.DONE)
