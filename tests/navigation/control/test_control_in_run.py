"""The control socket is a stage of the run: without it the robot holds, and systemd is not fed."""

from __future__ import annotations

from pathlib import Path

from navigation.control import ControlServer, send_order
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.run.virtual_world import VirtualWorld
from navigation.shared.supervisor import SupervisedPart
from tests.support.runs.virtual import cycle_until, is_driving, short_config
from tests.support.waiting import wait_until


def test_a_robot_that_nobody_could_stop_holds_until_the_socket_is_read_again(
    tmp_path: Path,
) -> None:
    config = short_config([{"x_m": 0.20, "y_m": 1.60}])
    with (
        Daemon(config, VirtualWorld(config, pictures=False), first_mission_id=7) as daemon,
        ControlServer(tmp_path / "run" / "c.sock", daemon.people) as control,
    ):
        daemon.look_after(
            "control socket",
            SupervisedPart(control.failure, control.restart),
            lambda: control.turns,
        )
        daemon.people.give(stations_of(config))
        cycle_until(daemon, is_driving)
        turns = daemon.turns()["control socket"]
        assert wait_until(lambda: daemon.turns()["control socket"] > turns)
        control._turn = None  # type: ignore[assignment, method-assign]
        assert wait_until(lambda: control.failure() is not None)
        held = cycle_until(daemon, lambda now: now.mission.state is State.HOLDING)
        assert "the control socket failed" in held.sentence
        del control._turn  # type: ignore[method-assign]
        cycle_until(daemon, lambda _: control.failure() is None)
        assert send_order(control.path, {"order": "status"})["ok"]
        cycle_until(daemon, is_driving)
