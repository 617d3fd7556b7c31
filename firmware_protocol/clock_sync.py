"""The robot's clock as the host sees it: offset and drift from round trips.

Each exchange gives the four times of NTP (RFC 5905). Of the last exchanges those with a round
trip near the shortest are trusted, and a regression with decaying weights gives offset and
drift. The robot counts microseconds modulo 2**32 (71.6 minutes); they are unrolled here.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final

WRAP_US: Final = 1 << 32
_KEPT: Final = 32
_TRUST_S: Final = 0.002
"""Exchanges this much slower than the fastest are not used."""
_DECAY_S: Final = 30.0
_DRIFT_MAX: Final = 1e-3
"""A thousand parts in a million: a ceramic resonator's worst."""


@dataclass(frozen=True, slots=True)
class _Sample:
    host_s: float
    offset_s: float
    round_trip_s: float


class ClockEstimate:
    """Offset of the robot's clock: ``robot_s = host_s + offset_s(host_s)``."""

    def __init__(self) -> None:
        self._samples: deque[_Sample] = deque(maxlen=_KEPT)
        self._last_robot_us: int | None = None
        self._turns = 0
        self._mean_s = 0.0
        self._offset_s = 0.0
        self.drift = 0.0

    @property
    def ready(self) -> bool:
        """Whether an exchange has succeeded."""
        return bool(self._samples)

    @property
    def round_trip_s(self) -> float:
        """The shortest round trip among the kept exchanges; infinity before the first."""
        return min((s.round_trip_s for s in self._samples), default=float("inf"))

    def add(self, sent_s: float, received_us: int, answered_us: int, now_s: float) -> None:
        """Take one exchange: host sent, robot received, robot answered, host received."""
        received_s = self._unrolled(received_us)
        answered_s = received_s + ((answered_us - received_us) % WRAP_US) / 1e6
        round_trip_s = (now_s - sent_s) - (answered_s - received_s)
        if round_trip_s < -_TRUST_S:
            return
        offset_s = ((received_s - sent_s) + (answered_s - now_s)) / 2.0
        self._samples.append(_Sample((sent_s + now_s) / 2.0, offset_s, round_trip_s))
        self._fit()

    def offset_s(self, host_s: float) -> float:
        """The robot's clock minus the host's at host time ``host_s``."""
        return self._offset_s + self.drift * (host_s - self._mean_s)

    def _unrolled(self, robot_us: int) -> float:
        if self._last_robot_us is not None and robot_us < self._last_robot_us - WRAP_US // 2:
            self._turns += 1
        self._last_robot_us = robot_us
        return (robot_us + self._turns * WRAP_US) / 1e6

    def _fit(self) -> None:
        limit_s = self.round_trip_s + _TRUST_S
        trusted = [s for s in self._samples if s.round_trip_s <= limit_s]
        newest_s = trusted[-1].host_s
        weights = [1.0 / (1.0 + (newest_s - s.host_s) / _DECAY_S) for s in trusted]
        total = sum(weights)
        mean_s = sum(w * s.host_s for w, s in zip(weights, trusted, strict=True)) / total
        offset_s = sum(w * s.offset_s for w, s in zip(weights, trusted, strict=True)) / total
        spread = sum(w * (s.host_s - mean_s) ** 2 for w, s in zip(weights, trusted, strict=True))
        slope = 0.0
        if trusted[-1].host_s - trusted[0].host_s > 5.0 and spread > 0.0:
            slope = (
                sum(
                    w * (s.host_s - mean_s) * (s.offset_s - offset_s)
                    for w, s in zip(weights, trusted, strict=True)
                )
                / spread
            )
        self.drift = max(-_DRIFT_MAX, min(_DRIFT_MAX, slope))
        self._mean_s, self._offset_s = mean_s, offset_s
