"""Attacks on the process that speaks a maker's protocol, while its robot drives.

A Create 2 has no watchdog: nothing stops it but bytes that arrive.
"""

from __future__ import annotations

import signal

from benchmarks.adversary.attacks.attack import Attack
from benchmarks.adversary.driver_rig import DriverRig
from benchmarks.adversary.rig import Needs, Rig
from tests.support.processes.busy import busy

CREATE2 = Needs(driver="create2")
ONSET_M = (0.1, 0.6)
BUSY = 6
"""Processes beside it that want the processor all the time."""
WATCH_S = 3.0


def _driver(rig: Rig) -> DriverRig:
    assert isinstance(rig, DriverRig)
    return rig


def _frozen(rig: Rig) -> None:
    _driver(rig).hurt(signal.SIGSTOP)
    rig.watch(WATCH_S)


def _killed_under_load(rig: Rig) -> None:
    with busy(BUSY):
        rig.watch(1.0)
        _driver(rig).hurt(signal.SIGKILL)
        rig.watch(WATCH_S)


def _frozen_at_the_end(rig: Rig) -> None:
    """The whole program gets SIGTERM before it can have missed a heartbeat."""
    _driver(rig).hurt(signal.SIGSTOP)
    _driver(rig).end_program()


def _frozen_over_a_stop(rig: Rig) -> None:
    """A person stops the robot at once; every state reported afterwards has to be true."""
    _driver(rig).hurt(signal.SIGSTOP)
    rig.stop()
    for _ in range(40):
        rig.status()
        rig.watch(0.05)
    rig.note_end()


ATTACKS = (
    Attack("driver", "frozen", _frozen, CREATE2, ONSET_M),
    Attack("driver", "killed on a loaded computer", _killed_under_load, CREATE2, ONSET_M),
    Attack("driver", "frozen, the program ended", _frozen_at_the_end, CREATE2, ONSET_M),
    Attack("driver", "frozen, a person orders a stop", _frozen_over_a_stop, CREATE2, ONSET_M),
)
