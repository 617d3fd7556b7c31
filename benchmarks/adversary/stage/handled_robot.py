"""`clearway robot` that a hand can carry, hold and turn: orders come on standard input, JSON lines.

- ``{"carry": [x_m, y_m, heading_rad], "seconds": S}``: lifted and put down there within S
- ``{"grip": SHARE}``: how much of the wheels' travel the floor takes; 0.0: they spin, the robot
  stands; 1.0: as always
- ``{"motors": false}``: they have no power, and the wheels stand; true: as always
"""

from __future__ import annotations

import json
import math
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

import numpy as np

from firmware_protocol.robot.controller import WheelSpeeds
from navigation.cli.running.robot import command
from navigation.simulator import robot as simulated
from navigation.simulator.drive_model import Drive, DriveModel, TruePose


class Hand:
    """What is being done to the robot; set by one thread, asked by another."""

    def __init__(self) -> None:
        self.grip = 1.0
        self.motors = True
        self.carry: tuple[float, float, TruePose] | None = None
        """From when, until when, and where to."""

    def listen(self) -> None:
        for line in sys.stdin:
            order = json.loads(line)
            if "grip" in order:
                self.grip = float(order["grip"])
            if "motors" in order:
                self.motors = bool(order["motors"])
            if "carry" in order:
                now_s = time.monotonic()
                self.carry = (now_s, now_s + float(order["seconds"]), TruePose(*order["carry"]))


HAND = Hand()


class HandledDrive(Drive):
    """A robot whose wheels may turn in the air."""

    def __init__(self, model: DriveModel, pose: TruePose, rng: np.random.Generator) -> None:
        super().__init__(model, pose, rng)
        self._lifted: TruePose | None = None

    def step(self, dt_s: float, wanted: WheelSpeeds) -> None:
        before = self.pose
        self.has_power = HAND.motors
        super().step(dt_s, wanted)
        grip, carry = HAND.grip, HAND.carry
        if grip < 1.0:
            turn = math.remainder(self.pose[2] - before[2], math.tau)
            x, y = (a + grip * (b - a) for a, b in zip(before[:2], self.pose[:2], strict=True))
            self.pose = TruePose(x, y, math.remainder(before[2] + grip * turn, math.tau))
        if carry is None:
            return
        begin_s, end_s, there = carry
        if self._lifted is None:
            self._lifted = before
        share = min(1.0, (time.monotonic() - begin_s) / (end_s - begin_s))
        turn = math.remainder(there[2] - self._lifted[2], math.tau)
        x, y = (a + share * (b - a) for a, b in zip(self._lifted[:2], there[:2], strict=True))
        self.pose = TruePose(x, y, math.remainder(self._lifted[2] + share * turn, math.tau))
        if share >= 1.0:
            HAND.carry = self._lifted = None


@contextmanager
def on_its_own_wheels() -> Iterator[None]:
    with patch.object(simulated, "Drive", HandledDrive):
        yield


if __name__ == "__main__":
    threading.Thread(target=HAND.listen, daemon=True).start()
    with on_its_own_wheels():
        sys.exit(command(standalone_mode=False))
