"""The driver's process and its ports, in real time: kills, pulled cables, ports in use."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.wire.messages import Waypoint, WaypointFlag
from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers import driver_watch
from navigation.link.drivers.driver_link import DriverLink
from navigation.link.drivers.driver_process import DriverProcess
from navigation.link.drivers.recognise import recognise
from navigation.link.serial_port import PortError, open_port
from navigation.simulator.robot import SimulatedRobot
from navigation.simulator.twins.kinds import TWINS
from tests.support.robots.driven_bench import settings_of
from tests.support.robots.on_its_way import on_its_way
from tests.support.waiting import wait_until

NAMES = tuple(KNOWN_ROBOTS)
END = WaypointFlag.STOP | WaypointFlag.END
PATIENCE_S = 20.0


@pytest.fixture(autouse=True)
def _nothing_hangs_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """A driver that gets no processor for 0.2 s would be ended: test_drivers_that_hang.py."""
    monkeypatch.setattr(driver_watch, "BEAT_MISSED_S", PATIENCE_S)


@contextmanager
def driven(name: str, twin: SimulatedRobot) -> Iterator[tuple[DriverProcess, DriverLink]]:
    """A driver on the twin, its link, and a control loop that gives poses and leases."""
    driver = DriverProcess(name, twin.port, KNOWN_ROBOTS[name].baud, settings_of(name))
    driver.start()
    over = threading.Event()

    def control(link: DriverLink) -> None:
        while not over.wait(0.033):
            with suppress(Exception):
                link.pose_fix(*twin.pose(), time.monotonic())
                link.lease(True, 0.01)

    try:
        with DriverLink(driver.port, driver.word) as link:
            thread = threading.Thread(target=control, args=(link,))
            thread.start()
            yield driver, link
            over.set()
            thread.join()
    finally:
        over.set()
        driver.stop()


def twin_of(name: str) -> SimulatedRobot:
    return SimulatedRobot(twin=TWINS[name](), rng=np.random.default_rng(3))


def send(link: DriverLink, mission: int = 5) -> None:
    assert wait_until(lambda: link.snapshot().clock_offset_s is not None, PATIENCE_S)
    link.upload(mission, [Waypoint(1.0, 0.0, 0.1), Waypoint(3.0, 0.0, 0.0, flags=END)])


def drives(twin: SimulatedRobot) -> bool:
    return twin.moving and twin.pose().x_m > 0.02


@pytest.mark.parametrize("name", ["create2", "epuck2"])
def test_a_program_that_is_killed_leaves_no_robot_that_drives_and_no_folder(
    name: str, tmp_path: Path
) -> None:
    """Its driver outlives it for as long as it takes to stop the robot."""
    with twin_of(name) as twin:
        program = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, name, twin.port],
            stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[4],
            env={**os.environ, "TMPDIR": str(tmp_path)},
        )  # fmt: skip
        try:
            assert wait_until(lambda: drives(twin), PATIENCE_S), program.poll()
            assert list(tmp_path.glob("clearway-driver-*"))
        finally:
            program.kill()
        began_s = time.monotonic()
        assert wait_until(lambda: not twin.moving, PATIENCE_S)
        assert time.monotonic() - began_s < 3.0
        program.communicate(timeout=PATIENCE_S)
        assert wait_until(lambda: not list(tmp_path.iterdir()), PATIENCE_S)


PROGRAM = """
import sys, time
from navigation.link.drivers import driver_watch
from navigation.link.drivers.driver_link import DriverLink
from navigation.link.drivers.driver_process import DriverProcess
from firmware_protocol.wire.messages import Waypoint, WaypointFlag
from tests.support.robots.driven_bench import settings_of
from navigation.config.known_robots import KNOWN_ROBOTS

def main():
    name, port = sys.argv[1:]
    driver_watch.BEAT_MISSED_S = 20.0
    driver = DriverProcess(name, port, KNOWN_ROBOTS[name].baud, settings_of(name))
    driver.start()
    link = DriverLink(driver.port, driver.word)
    link.open()
    sent = False
    while True:
        link.pose_fix(0.0, 0.0, 0.0, time.monotonic())
        link.lease(True, 0.01)
        if not sent and link.snapshot().clock_offset_s is not None:
            end = WaypointFlag.STOP | WaypointFlag.END
            link.upload(5, [Waypoint(1.0, 0.0, 0.1), Waypoint(3.0, 0.0, 0.0, flags=end)])
            sent = True
        time.sleep(0.03)  # the pace of a control loop

if __name__ == "__main__":
    main()
"""


@pytest.mark.parametrize("name", NAMES)
def test_a_cable_that_is_pulled_is_said_and_the_mission_kept(name: str) -> None:
    with twin_of(name) as twin, driven(name, twin) as (_driver, link):
        send(link)
        assert on_its_way(link, lambda: drives(twin), PATIENCE_S)
        mission = link.snapshot().mission_id
        twin.unplug()
        title = KNOWN_ROBOTS[name].title
        assert wait_until(lambda: "gone silent" in str(link.snapshot().down_reason), PATIENCE_S)
        assert str(link.snapshot().down_reason).startswith(f"the {title} on {twin.port}")
        twin.unplug(False)
        assert wait_until(lambda: link.snapshot().down_reason is None, PATIENCE_S)
        assert wait_until(lambda: not twin.moving, PATIENCE_S)
        assert link.snapshot().mission_id == mission
        assert not link.snapshot().running
        assert on_its_way(link, lambda: twin.moving, PATIENCE_S)


def test_a_bumper_is_told_with_the_link() -> None:
    with twin_of("create2") as twin, driven("create2", twin) as (_driver, link):
        send(link)
        assert on_its_way(link, lambda: drives(twin), PATIENCE_S)
        twin.bump()
        assert wait_until(lambda: link.snapshot().estopped, PATIENCE_S)
        assert wait_until(
            lambda: link.snapshot().fault == "iRobot Create 2: its bumper is pressed", PATIENCE_S
        )
        assert wait_until(lambda: not twin.moving, PATIENCE_S)


def test_a_port_that_is_not_there_and_one_that_is_taken_are_named(tmp_path: Path) -> None:
    missing = tmp_path / "robot"
    driver = DriverProcess("create2", str(missing), 115_200, settings_of("create2"))
    driver.start()
    try:
        assert wait_until(lambda: "there is no such device" in str(driver.word().silence))
        with twin_of("create2") as twin, open_port(twin.port, 115_200):
            missing.symlink_to(twin.port)
            assert wait_until(
                lambda: (
                    str(driver.word().silence)
                    == f"serial port {missing}: is in use by another program"
                )
            ), driver.word()
            assert not twin.moving
        missing.unlink()
    finally:
        driver.stop()
    assert not Path(driver.port).exists()


@pytest.mark.parametrize("name", NAMES)
def test_a_robot_is_recognised_by_the_right_driver_only(name: str) -> None:
    with twin_of(name) as twin:
        found = recognise(twin.port, twin.twin.baud, "create2")
        assert found.name == name
        assert found.sentence.startswith(KNOWN_ROBOTS[name].title)
        assert not twin.moving


def test_a_port_with_nobody_behind_it_is_called_silent() -> None:
    with twin_of("create2") as twin:
        twin.unplug()
        found = recognise(twin.port, 115_200, "turtlebot3")
    assert found.name is None
    assert "the TurtleBot3 on" in found.sentence
    assert "does not answer" in found.sentence
    with pytest.raises(PortError, match="no such device"):
        recognise("/dev/no-such-robot", 115_200, "create2")


def test_a_robot_behind_an_address_is_driven_too() -> None:
    """As through a Wi-Fi bridge: a server that passes bytes between a socket and the port."""
    with twin_of("waveshare") as twin, socket.create_server(("127.0.0.1", 0)) as server:
        over = threading.Event()

        def bridge() -> None:
            client, _ = server.accept()
            with client, open_port(twin.port, 115_200) as port:
                client.settimeout(0.005)
                while not over.is_set():
                    with suppress(OSError):  # nothing came, or the driver has gone
                        port.write(client.recv(4096))
                    with suppress(OSError):
                        client.sendall(port.read(4096))

        thread = threading.Thread(target=bridge, daemon=True)
        thread.start()
        address = f"socket://127.0.0.1:{server.getsockname()[1]}"
        driver = DriverProcess("waveshare", address, 115_200, settings_of("waveshare"))
        driver.start()
        try:
            assert wait_until(lambda: driver.word().identity == "Waveshare UGV", PATIENCE_S)
            assert driver.word().silence is None
        finally:
            driver.stop()
            over.set()
            thread.join()


def test_an_address_that_nobody_listens_at_is_named() -> None:
    with pytest.raises(PortError, match=r"serial port socket://127.0.0.1:9: Connection refused"):
        recognise("socket://127.0.0.1:9", 115_200, "waveshare")
