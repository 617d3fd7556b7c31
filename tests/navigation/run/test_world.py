"""What a run is connected to, where part of it is another process."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from navigation.config import Config, load_config
from navigation.run.devices.world_clock import world_clock
from navigation.run.world import World
from navigation.simulator.shared_pose import PoseFileError, PoseWriter
from tests.support.waiting import wait_until
from vision.camera.camera import CameraError

CONFIGS = Path(__file__).parents[3] / "configs"


@pytest.fixture
def config(tmp_path: Path) -> Config:
    """The run with a robot in another process, which tells its poses in a folder of the test."""
    loaded = load_config(CONFIGS / "hardware_in_the_loop.yaml", {})
    assert loaded.simulation is not None
    (tmp_path / "pose").touch()
    robot = loaded.simulation.robot.model_copy(update={"poses": tmp_path / "pose"})
    changed = loaded.simulation.model_copy(update={"robot": robot})
    return loaded.model_copy(update={"simulation": changed})


def test_a_run_does_not_begin_without_the_robot_s_file(config: Config, tmp_path: Path) -> None:
    (tmp_path / "pose").unlink()
    with pytest.raises(PoseFileError, match=r"No such file or directory; does `clearway robot`"):
        World(config)


def test_there_is_no_picture_of_a_robot_that_told_no_pose(config: Config, tmp_path: Path) -> None:
    camera = World(config).open_camera()
    camera.open()
    with pytest.raises(CameraError, match=r"simulated camera: pose file .*`clearway robot` run"):
        camera.read(1.0)
    PoseWriter(tmp_path / "pose").write(0.2, 0.2, 1.5)
    assert camera.read(1.0) is not None


@pytest.mark.parametrize("spoil", [Path.unlink, lambda path: path.write_bytes(b"")])
def test_a_camera_waits_for_the_robot_s_file_and_comes_back_with_it(
    spoil: Callable[[Path], object], config: Config, tmp_path: Path
) -> None:
    """An error of the file once ended the camera's thread for good."""
    path = tmp_path / "pose"
    with World(config).make_frames() as frames:
        assert wait_until(lambda: frames.status().state == "lost")
        assert "does `clearway robot` run?; trying again in" in frames.status().reason
        PoseWriter(path).write(0.2, 0.2, 1.5)
        assert frames.take(60.0) is not None
        spoil(path)
        assert wait_until(lambda: frames.status().state == "lost")
        PoseWriter(path).write(0.2, 0.2, 1.5)
        assert wait_until(lambda: frames.status().state == "running")
        assert not frames.has_died()


def test_a_simulated_world_waits_for_the_late_thread_of_a_link(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    world = World(load_config(CONFIGS / "simulation.yaml", {}))
    goes_on = threading.Event()
    try:
        with world.make_link("") as link:
            assert wait_until(lambda: link.turns > 1)
            monkeypatch.setattr(link, "_publish", goes_on.wait)
            began_s, wall_s = world.clock(), time.monotonic()
            passed_s = 0.0
            while time.monotonic() < wall_s + 0.6:  # below what a hanging thread is given
                passed_s = world.clock() - began_s
                time.sleep(0.01)  # the clock is read often, as a run does
            goes_on.set()
            assert passed_s < 0.3
            assert wait_until(lambda: world.clock() > began_s + 0.3)
    finally:
        world.stop()


@pytest.mark.parametrize(
    ("name", "waits"),
    [
        ("simulation", True),
        ("fleet", True),
        ("two_cameras_fleet", True),
        ("hardware_in_the_loop", False),
        ("create2", False),
        ("real_camera", False),
    ],
)
def test_time_waits_only_in_a_world_where_all_is_simulated(name: str, waits: bool) -> None:
    clock = world_clock(load_config(CONFIGS / f"{name}.yaml", {}))
    clock.waits_for("a part that is late", lambda: 0.0, 0.0)
    before_s = clock()
    time.sleep(0.02)  # time that the wall's clock counts
    assert (clock() - before_s < 0.01) == waits
