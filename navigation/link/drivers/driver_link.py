"""The serial link to a robot behind a driver, with the driver's report on it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Final

from navigation.link.drivers.word_of_robot import Word
from navigation.link.link_snapshot import LinkSnapshot
from navigation.link.serial_link import SerialLink

LINE_BAUD: Final = 1_000_000
"""Baud of the wire to the driver's process, a pseudo-terminal, which is no slower."""


class DriverLink(SerialLink):
    """`SerialLink` whose snapshots say why the robot itself is out of reach, stopped, or weak."""

    def __init__(
        self,
        port: str,
        word: Callable[[], Word],
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        # its port comes and goes with the process
        super().__init__(port, LINE_BAUD, clock=clock, wait_for_port=True)
        self._word_now = word

    def snapshot(self) -> LinkSnapshot:
        """Present state; the driver's sentences come first."""
        snapshot, word = super().snapshot(), self._word_now()
        down = snapshot.down_reason
        if word.silence is not None:
            down = word.silence
        fault = word.fault or snapshot.fault
        return replace(
            snapshot, down_reason=down, fault=fault, remark=word.remark, stands=word.stands
        )
