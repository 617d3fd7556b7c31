"""The simulated fleet in its own process: the same pictures and wheels, an end for everybody."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from navigation.config import Config, load_config
from navigation.link.serial_link import SerialLink
from navigation.run.devices.world_clock import WallClock
from navigation.run.simulation import Simulation
from navigation.run.simulation_apart import SimulationApart
from tests.support.waiting import wait_until
from vision.camera.camera import CameraError

CONFIGS = Path(__file__).parents[3] / "configs"


@pytest.fixture(scope="module")
def config() -> Config:
    return load_config(CONFIGS / "alcove.yaml")


@pytest.fixture
def apart(config: Config) -> Iterator[SimulationApart]:
    simulation = SimulationApart(config)
    yield simulation
    simulation.stop()


@pytest.fixture(scope="module")
def shared(config: Config) -> Iterator[SimulationApart]:
    """One for tests that leave it as it was, but for the numbers of its pictures."""
    simulation = SimulationApart(config)
    yield simulation
    simulation.stop()


def test_its_camera_shows_what_the_camera_of_this_process_shows(
    config: Config, apart: SimulationApart
) -> None:
    clock = WallClock()
    here = Simulation(config, clock)
    cameras = [apart.open_camera(), here.open_camera()]
    pictures = []
    for camera in cameras:
        camera.open()
        frame = camera.read(5.0)
        assert frame is not None
        assert camera.state == "running"
        assert not frame.image.flags.writeable
        assert 0.0 <= clock() - frame.captured_s < 5.0
        pictures.append(frame.image)
        camera.close()
    assert np.array_equal(*pictures)
    assert cameras[0].may_repeat == cameras[1].may_repeat
    assert cameras[0].name == cameras[1].name


def test_a_camera_that_is_asked_too_early_gives_nothing_yet(shared: SimulationApart) -> None:
    camera = shared.open_camera()
    camera.open()
    assert camera.read(5.0) is not None
    # on a busy machine the next picture may be due before it is asked for
    assert wait_until(lambda: camera.read(0.0) is None)
    camera.close()


def test_a_camera_that_is_not_open_says_so(shared: SimulationApart) -> None:
    with pytest.raises(CameraError, match="is not open"):
        shared.open_camera().read(0.1)


def test_its_robots_answer_at_their_ports_and_keep_their_track(shared: SimulationApart) -> None:
    assert len(set(shared.ports.values())) == 2
    shared.start()
    with SerialLink(shared.ports["left"]) as link:
        assert wait_until(lambda: link.snapshot().status is not None)
    assert shared.pose("left") == pytest.approx((0.20, 0.90, 0.0))
    assert wait_until(lambda: len(shared.track("left")) > 2)
    assert np.ptp(shared.track("left")[:, 1:], axis=0).max() == 0.0


def test_when_its_process_dies_the_camera_and_the_links_say_so(apart: SimulationApart) -> None:
    apart.start()
    camera = apart.open_camera()
    camera.open()
    with SerialLink(apart.ports["left"]) as link:
        assert wait_until(lambda: link.snapshot().status is not None)
        apart.process.kill()
        with pytest.raises(CameraError, match="the simulation's process has ended"):
            camera.read(5.0)
        assert wait_until(lambda: link.snapshot().down_reason is not None)
    assert apart.track("left").shape == (0, 4)
    camera.close()


def test_it_ends_with_the_process_that_asks_for_it() -> None:
    program = f"""
import os
from pathlib import Path
from navigation.config import load_config
from navigation.run.simulation_apart import SimulationApart
if __name__ == "__main__":
    simulation = SimulationApart(load_config(Path({str(CONFIGS / "alcove.yaml")!r})))
    print(simulation.process.pid, flush=True)
    os.kill(os.getpid(), 9)
"""
    told = subprocess.run(
        [sys.executable, "-c", program], check=False, capture_output=True, text=True, timeout=120
    )
    pid = int(told.stdout)
    assert wait_until(lambda: not is_alive(pid))


def is_alive(pid: int) -> bool:
    """Whether the process does something still: who waits for its parent to look is dead."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state != "Z"


def test_each_of_several_cameras_gives_its_own_pictures_at_the_same_time() -> None:
    simulation = SimulationApart(load_config(CONFIGS / "two_cameras_fleet.yaml"))
    try:
        pictures = []
        cameras = [simulation.open_camera(name) for name in ("left", "right")]
        for camera in cameras:
            camera.open()
        with ThreadPoolExecutor() as pool:
            for frame in pool.map(lambda camera: camera.read(5.0), cameras):
                assert frame is not None
                pictures.append(frame.image)
        assert not np.array_equal(*pictures)
    finally:
        simulation.stop()
