"""Attacks on processes: stopped for a while, killed, started again."""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.adversary.attacks.attack import Act, Attack
from benchmarks.adversary.processes import Process
from benchmarks.adversary.rig import AFTER_STOP_S, Needs, Rig

FREEZES_S = (0.1, 0.4, 1.0, 3.0)
HTTP = Needs(http_camera=True)


def _freezes(of: Callable[[Rig], Process], freezes_s: tuple[float, ...]) -> Act:
    def act(rig: Rig) -> None:
        for seconds in freezes_s:
            rig.freeze(of(rig), seconds)
            rig.watch(float(rig.rng.uniform(0.8, 2.0)))

    return act


def _daemon(rig: Rig) -> Process:
    return rig.daemon


def _robot(rig: Rig) -> Process:
    return rig.robot


def _camera(rig: Rig) -> Process:
    assert rig.camera is not None
    return rig.camera


def _paused_while_frozen(rig: Rig) -> None:
    """The robot's process sleeps over a pause: what waits in its receiver is of before."""
    rig.freeze(rig.robot, 1.2, lambda: rig.order(order="pause"))
    rig.watch(3.0)


def _killed(kills: int) -> Act:
    """kill -9 of the program at random moments; another goes on with the journal."""

    def act(rig: Rig) -> None:
        for _ in range(kills):
            rig.daemon.popen.kill()
            rig.watch(1.5)
            rig.start_daemon()
            rig.wait_for_answer()
            rig.watch(float(rig.rng.uniform(0.2, 4.0)))

    return act


def _killed_while_it_starts(rig: Rig) -> None:
    rig.daemon.popen.kill()
    for _ in range(2):
        rig.start_daemon()
        rig.watch(float(rig.rng.uniform(2.0, 6.0)))
        rig.daemon.popen.kill()
    rig.start_daemon()
    rig.wait_for_answer()
    rig.watch(3.0)


def _stopped_and_killed(rig: Rig) -> None:
    """A stop outlives the program: the judge's stop is this one, and nobody re-arms."""
    rig.stop()
    rig.watch(AFTER_STOP_S)
    rig.daemon.popen.kill()
    rig.watch(float(rig.rng.uniform(0.0, 1.0)))
    rig.start_daemon()
    rig.wait_for_answer()
    rig.watch(6.0)


def _camera_killed(rig: Rig) -> None:
    _camera(rig).popen.kill()
    rig.watch(2.0)
    rig.start_camera()
    rig.watch_mission(6.0)


def _motors_dead(rig: Rig) -> None:
    """The wheels stand, whatever is ordered; everything else works."""
    rig.power(False)
    rig.watch_mission(12.0, however_long=True)
    rig.note_end()
    rig.power(True)
    rig.watch_mission(4.0)


ATTACKS = (
    Attack("process", "the program stopped for 0.1 to 3 s", _freezes(_daemon, FREEZES_S)),
    Attack("process", "the robot's process stopped for 0.1 to 3 s", _freezes(_robot, FREEZES_S)),
    Attack("process", "the robot's process stopped over a pause", _paused_while_frozen),
    Attack("process", "the camera stopped for 0.1 to 3 s", _freezes(_camera, FREEZES_S), HTTP),
    Attack("process", "the program killed twice", _killed(2)),
    Attack("process", "the program killed while it starts", _killed_while_it_starts),
    Attack("process", "stopped, the program killed and begun again", _stopped_and_killed),
    Attack("process", "the robot's motors dead", _motors_dead, Needs(handled=True)),
    Attack("process", "the camera killed, started again", _camera_killed, HTTP),
)
