"""The thread that owns the port, over real pseudo-terminals."""

import errno
import math
import os
import random
import threading
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import serial

from firmware_protocol.host.events import MissionDone, MissionVoid
from firmware_protocol.host.state import LinkState
from firmware_protocol.robot.controller import RobotController
from firmware_protocol.wire.errors import LocalError
from firmware_protocol.wire.messages import RobotState, Waypoint
from firmware_protocol.wire.mission import Mission
from navigation.link.serial_link import LinkSnapshot, SerialLink
from navigation.link.serial_port import PortError, PortNotReadyError, look_for_port, open_port
from navigation.simulator.line_faults import FaultSpec
from navigation.simulator.robot import SimulatedRobot
from navigation.simulator.twins.clearway import ClearwayTwin
from tests.support.robots.on_its_way import on_its_way
from tests.support.waiting import wait_until


@contextmanager
def controlled(link: SerialLink, robot: SimulatedRobot) -> Iterator[threading.Event]:
    """A control loop: poses and leases while the event is set."""
    alive, over = threading.Event(), threading.Event()
    alive.set()

    def loop() -> None:
        while not over.wait(0.033):
            if alive.is_set():
                link.pose_fix(*robot.pose(), time.monotonic())
                link.lease(True, 0.01)

    thread = threading.Thread(target=loop)
    thread.start()
    try:
        yield alive
    finally:
        over.set()
        thread.join()


def robot(seed: int = 1, **options: object) -> SimulatedRobot:
    return SimulatedRobot(
        rng=np.random.default_rng(seed),
        twin=ClearwayTwin(boot_ids=random.Random(seed)),
        **options,  # type: ignore[arg-type]
    )


def control(robot: SimulatedRobot) -> RobotController:
    """What the robot decides."""
    assert isinstance(robot.twin, ClearwayTwin)
    return robot.twin.controller


def is_up(link: SerialLink) -> bool:
    return link.snapshot().down_reason is None


def driven(link: SerialLink) -> bool:
    """Wait for the mission's end."""
    return on_its_way(link, lambda: link.snapshot().mission_done, 60.0)


LINE = [Waypoint(0.02 * i, 0.0, 0.4) for i in range(30)]
LONG = [Waypoint(0.02 * i, 0.0, 0.4) for i in range(150)]
"""Seven seconds: a test that a busy machine holds up still finds the robot on its way."""


def test_a_mission_is_driven_over_a_pseudo_terminal() -> None:
    with robot() as there, SerialLink(there.port) as link, controlled(link, there):
        assert wait_until(lambda: is_up(link))
        mission = link.upload(7, LINE)
        assert driven(link), link.snapshot()
        snapshot = link.snapshot()
        assert (snapshot.mission_id, snapshot.executed) == (7, len(LINE))
        assert control(there).exec_crc == mission.prefix_crc(len(LINE))
        assert MissionDone(7) in link.events()
        assert math.dist(there.pose()[:2], (LINE[-1].x_m, 0.0)) < 0.006
        assert snapshot.standing_reason == "it has finished its mission"
        assert snapshot.rtt_s is not None
        assert len(there.track()) > 50


def test_a_mission_is_driven_over_a_bad_line() -> None:
    faults = FaultSpec.parse("drop=0.001,flip=0.0005,dup=0.01,stall=0.1@1")
    with robot(faults=faults) as there, SerialLink(there.port) as link, controlled(link, there):
        assert wait_until(lambda: is_up(link))
        mission = link.upload(7, LINE)
        assert driven(link), link.snapshot()
        assert control(there).exec_crc == mission.prefix_crc(len(LINE))


def test_emergency_stop_is_confirmed_and_left_in_a_fresh_session() -> None:
    with robot() as there, SerialLink(there.port) as link, controlled(link, there):
        assert wait_until(lambda: is_up(link))
        link.upload(7, LONG)
        assert on_its_way(link, lambda: there.moving, 20.0)
        link.estop()
        assert wait_until(lambda: link.snapshot().estopped, 2.0)
        assert wait_until(lambda: not there.moving, 2.0)
        assert not link.snapshot().estop_pending
        assert any(isinstance(event, MissionVoid) for event in link.events())
        link.reset_estop()
        assert wait_until(lambda: control(there).state is RobotState.IDLE, 5.0)
        assert wait_until(lambda: not link.snapshot().estopped, 5.0)


def test_the_robot_stops_when_the_control_loop_hangs_although_the_thread_lives() -> None:
    with robot() as there, SerialLink(there.port) as link, controlled(link, there) as alive:
        assert wait_until(lambda: is_up(link))
        link.upload(7, LONG)
        assert on_its_way(link, lambda: there.moving, 20.0)
        alive.clear()
        assert wait_until(lambda: control(there).state is RobotState.HOLD, 2.0)
        assert is_up(link)
        alive.set()
        assert not wait_until(lambda: control(there).state is RobotState.RUN, 0.5)
        assert driven(link)


def test_a_lease_is_dated_by_the_control_loop_and_not_by_a_thread_that_was_late() -> None:
    """A link whose thread was held up sends no permit of before as one of now."""
    now_s = [100.0]
    link = SerialLink("/dev/none", clock=lambda: now_s[0])
    given: list[float] = []
    link._host.lease = lambda issued_s, *_rest: given.append(issued_s)  # type: ignore[method-assign]
    link.lease(True)
    now_s[0] = 101.5
    link._take_orders()
    assert given == [100.0]


def test_a_thread_that_is_held_up_is_late_until_it_has_done_its_work() -> None:
    goes = threading.Event()

    def clock() -> float:
        if threading.current_thread().name == "serial link":
            goes.wait()
        return time.monotonic()

    goes.set()
    with robot() as there, SerialLink(there.port, clock=clock) as link:
        assert wait_until(lambda: is_up(link))
        goes.clear()
        link.lease(True)
        ordered_s = time.monotonic()
        assert wait_until(lambda: time.monotonic() > ordered_s + 0.3)
        assert link.late_since_s() <= ordered_s
        goes.set()
        assert wait_until(lambda: link.late_since_s() > ordered_s + 0.3)
    assert link.late_since_s() == math.inf


def test_a_re_arm_is_known_from_the_order_on_until_the_robot_has_answered() -> None:
    with robot() as there, SerialLink(there.port) as link, controlled(link, there):
        assert wait_until(lambda: is_up(link))
        link.estop()
        assert wait_until(lambda: link.snapshot().estopped, 2.0)
        assert not link.snapshot().leaving_estop
        link.reset_estop()
        assert link.snapshot().leaving_estop, "before the thread has seen the order"
        assert wait_until(lambda: not link.snapshot().leaving_estop, 5.0)
        assert not link.snapshot().estopped


def test_a_stop_pressed_after_a_re_arm_is_not_undone_by_it() -> None:
    """The stop overtakes the queue; the re-arm that still waits there is older than the stop."""
    link = SerialLink("/dev/none")
    link.reset_estop()
    assert link.snapshot().leaving_estop
    link.estop()
    link._take_orders()
    link._publish()
    assert link.snapshot().estop_pending
    assert not link.snapshot().leaving_estop


def test_a_missing_port_is_one_clear_sentence(tmp_path: Path) -> None:
    with pytest.raises(PortError, match="there is no such device"):
        SerialLink(str(tmp_path / "ttyUSB9")).open()


def test_a_file_is_no_serial_port(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("")
    with pytest.raises(PortError, match="is no serial port"):
        SerialLink(str(path)).open()
    with pytest.raises(PortError, match="is no serial port"):
        SerialLink("/dev/null").open()


def test_a_busy_port_is_one_clear_sentence() -> None:
    with (
        robot() as there,
        SerialLink(there.port),
        pytest.raises(PortError, match=r"in use by another program"),
    ):
        SerialLink(there.port).open()


def test_a_port_that_is_missing_at_the_start_is_waited_for_if_wanted(tmp_path: Path) -> None:
    name = tmp_path / "robot"
    with SerialLink(str(name), wait_for_port=True) as link:
        down = f"serial port {name}: there is no such device; is the cable plugged in?"
        assert link.snapshot().state is LinkState.CLOSED
        assert link.snapshot().down_reason == down
        turns = link.turns
        assert wait_until(lambda: link.turns > turns + 3), "the watchdog sees a live thread"
        with robot() as there:
            name.symlink_to(there.port)
            assert wait_until(lambda: is_up(link)), link.snapshot().down_reason


def test_a_stop_given_before_the_port_is_there_is_the_first_thing_that_the_robot_hears(
    tmp_path: Path,
) -> None:
    name = tmp_path / "robot"
    with SerialLink(str(name), wait_for_port=True) as link:
        link.estop()
        assert wait_until(lambda: link.snapshot().estop_pending)
        with robot() as there:
            name.symlink_to(there.port)
            assert wait_until(lambda: control(there).state is RobotState.ESTOP)
            assert wait_until(lambda: link.snapshot().estopped)


def test_a_port_that_another_program_uses_is_waited_for_if_wanted() -> None:
    with robot() as there:
        with SerialLink(there.port):
            later = SerialLink(there.port, wait_for_port=True)
            later.open()
            assert "in use by another program" in (later.snapshot().down_reason or "")
        try:
            assert wait_until(lambda: is_up(later)), later.snapshot().down_reason
        finally:
            later.close()


@pytest.mark.parametrize(
    ("number", "words"),
    [(errno.EACCES, "has to be in the group dialout"), (errno.EIO, "is there a device behind it")],
)
def test_a_port_that_may_not_be_opened_yet_is_worth_waiting_for(
    monkeypatch: pytest.MonkeyPatch, number: int, words: str
) -> None:
    """Permissions that udev sets a moment later; an adapter that has not come up."""

    def refuse(*_args: object, **_kwargs: object) -> None:
        raise serial.SerialException(number, "could not open port")

    monkeypatch.setattr(serial, "Serial", refuse)
    with pytest.raises(PortNotReadyError, match=words):
        open_port("/dev/ptmx", 115_200)


@pytest.mark.parametrize("wait_for_port", [False, True])
def test_what_is_no_serial_port_is_never_waited_for(tmp_path: Path, wait_for_port: bool) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for path in (tmp_path, tmp_path / "file", tmp_path / "file" / "x", tmp_path / "loop"):
        with pytest.raises(PortError) as found:
            look_for_port(str(path))
        assert not isinstance(found.value, PortNotReadyError), found.value
    with pytest.raises(PortError, match="is no serial port"):
        SerialLink("/dev/null", wait_for_port=wait_for_port).open()
    with pytest.raises(PortError, match="a path such as /dev/ttyUSB0"):
        SerialLink("ttyUSB0", wait_for_port=wait_for_port).open()


@pytest.mark.timed  # says how long closing takes
def test_closing_is_quick_and_frees_the_port() -> None:
    with robot() as there:
        link = SerialLink(there.port)
        link.open()
        assert wait_until(lambda: is_up(link))
        began_s = time.monotonic()
        link.close()
        assert time.monotonic() - began_s < 0.2
        assert link.snapshot().state is LinkState.CLOSED
        open_port(there.port, 115_200).close()
        link.close()
        link.lease(True)
        link.estop()


def test_a_closed_link_can_be_opened_again() -> None:
    with robot() as there:
        link = SerialLink(there.port)
        for _ in range(2):
            with link:
                assert wait_until(lambda: is_up(link))
        assert link.snapshot().sent.sessions == 2


def test_a_silent_port_says_what_to_look_at() -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    try:
        with SerialLink(os.ttyname(slave)) as link:
            assert wait_until(lambda: "no byte" in (link.snapshot().down_reason or ""), 3.0)
    finally:
        os.close(master)
        os.close(slave)


def test_a_port_that_goes_away_is_found_again_by_its_name(tmp_path: Path) -> None:
    """A stable name, as /dev/serial/by-id gives it, that leads to another device later."""
    name = tmp_path / "robot"
    with robot() as first:
        name.symlink_to(first.port)
        link = SerialLink(str(name))
        link.open()
        try:
            assert wait_until(lambda: is_up(link))
            first.stop()
            assert wait_until(lambda: not is_up(link), 3.0)
            assert "broke" in str(link.snapshot().down_reason) or wait_until(
                lambda: link.snapshot().down_reason is not None
            )
            name.unlink()
            with robot(seed=2) as second:
                name.symlink_to(second.port)
                assert wait_until(lambda: is_up(link), 10.0), link.snapshot().down_reason
                assert link.snapshot().state is LinkState.REBOOTED
        finally:
            link.close()


def test_a_new_process_goes_on_with_the_robots_mission() -> None:
    with robot() as there:
        with SerialLink(there.port) as first, controlled(first, there):
            assert wait_until(lambda: is_up(first))
            first.upload(7, LONG)
            assert on_its_way(first, lambda: first.snapshot().executed >= 5, 20.0)
        with SerialLink(there.port) as second, controlled(second, there):
            second.upload(7, LONG, start=False)
            assert wait_until(lambda: is_up(second))
            assert wait_until(lambda: not there.moving)
            assert 5 <= second.snapshot().executed < len(LONG)
            assert driven(second)
            assert control(there).exec_crc == Mission(7, LONG).prefix_crc(len(LONG))


def test_what_the_wire_cannot_carry_is_refused_in_the_callers_thread() -> None:
    link = SerialLink("/dev/none")
    with pytest.raises(LocalError):
        link.upload(0, LINE)
    with pytest.raises(LocalError, match="x_m"):
        link.upload(1, [Waypoint(3000.0, 0.0, 0.1)])
    with pytest.raises(LocalError):
        link.pose_fix(math.nan, 0.0, 0.0, 0.0)
    with pytest.raises(LocalError):
        link.lease(True, math.nan)


def test_a_closed_link_says_so() -> None:
    snapshot = SerialLink("/dev/none").snapshot()
    assert isinstance(snapshot, LinkSnapshot)
    assert snapshot.down_reason == "the port is not open"
    assert snapshot.heard_age_s == math.inf
