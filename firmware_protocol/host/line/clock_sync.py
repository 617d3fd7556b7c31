"""The robot's clock as seen by the host: offset and drift from round trips, with a bound.

Each exchange gives the four times of NTP (RFC 5905). A regression with decaying weights over those
with a round trip near the shortest gives offset and drift. The offset is known to about half a
round trip: the bound ``error_s``. If an exchange contradicts it, a clock has jumped, and the
estimate restarts.

The robot counts microseconds modulo 2**32 (71.6 minutes).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Final

WRAP_US: Final = 1 << 32
_KEPT: Final = 32
_TRUST_S: Final = 0.002
"""Excess over the fastest exchange at which one is not used."""
_DECAY_S: Final = 30.0
_DRIFT_MAX: Final = 1e-3
"""A ceramic resonator's worst drift."""
DOUBT_S: Final = 0.03
"""Delay of a report from which a clock may have jumped."""


@dataclass(frozen=True, slots=True)
class _Sample:
    host_s: float
    offset_s: float
    round_trip_s: float
    error_s: float
    """Largest error of the offset then."""


class ClockEstimate:
    """Offset of the robot's clock: ``robot_s = host_s + offset_s(host_s)``."""

    def __init__(self) -> None:
        self.jumps = 0
        """Jumps of either clock."""
        self._samples: deque[_Sample] = deque(maxlen=_KEPT)
        self._mean_s = 0.0
        self._offset_s = 0.0
        self.drift = 0.0

    @property
    def ready(self) -> bool:
        """True if an exchange has succeeded."""
        return bool(self._samples)

    @property
    def round_trip_s(self) -> float:
        """Shortest round trip of the kept exchanges; infinity before the first."""
        return min((s.round_trip_s for s in self._samples), default=math.inf)

    def add(
        self,
        sent_s: float,
        received_us: int,
        answered_us: int,
        now_s: float,
        wire_s: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Take one exchange: host sent, robot received, robot answered, host received.

        ``wire_s`` is the least time of question and answer on the line, in seconds: it corrects the
        offset, but less if an exchange took less (USB). The bound holds without it.
        """
        received_s = self._unrolled(received_us, now_s)
        answered_s = received_s + ((answered_us - received_us) % WRAP_US) / 1e6
        low_s, high_s = answered_s - now_s, received_s - sent_s
        round_trip_s = high_s - low_s
        if round_trip_s < -_TRUST_S:
            return
        share = min(1.0, max(0.0, round_trip_s) / max(sum(wire_s), 1e-9))
        longer_back_s = (wire_s[1] - wire_s[0]) * share
        offset_s = (low_s + high_s + longer_back_s) / 2.0
        error_s = max(abs(offset_s - low_s), abs(high_s - offset_s))
        sample = _Sample((sent_s + now_s) / 2.0, offset_s, round_trip_s, error_s)
        self._forget_what_contradicts(sample, now_s)
        self._samples.append(sample)
        self._fit()

    def offset_s(self, host_s: float) -> float:
        """Robot's clock minus the host's at host time ``host_s``."""
        return self._offset_s + self.drift * (host_s - self._mean_s)

    def error_s(self, host_s: float) -> float:
        """Largest possible error of ``offset_s``; infinity before the first exchange.

        Half of the best round trip, and possible drift since.
        """
        offset_s = self.offset_s(host_s)
        errors_s = [
            abs(offset_s - s.offset_s) + s.error_s + _DRIFT_MAX * abs(host_s - s.host_s)
            for s in self._samples
        ]
        return min(errors_s, default=math.inf)

    def robot_us(self, host_s: float) -> int:
        """Robot's clock at that host time, modulo 2**32."""
        return round((host_s + self.offset_s(host_s)) * 1e6) % WRAP_US

    def host_s(self, robot_us: int, now_s: float) -> float:
        """Host time of the robot's clock reading nearest to ``now_s``."""
        return now_s + _short_us(robot_us - self.robot_us(now_s)) / 1e6

    def is_in_doubt(self, robot_us: int, now_s: float) -> bool:
        """True if a report just received does not fit the estimate."""
        if not self.ready:
            return False
        late_s, error_s = now_s - self.host_s(robot_us, now_s), self.error_s(now_s)
        return not -error_s <= late_s <= error_s + DOUBT_S

    def _forget_what_contradicts(self, sample: _Sample, now_s: float) -> None:
        apart_s = abs(sample.offset_s - self.offset_s(now_s))
        if self.ready and apart_s > sample.error_s + self.error_s(now_s):
            self._samples.clear()
            self.jumps += 1

    def _unrolled(self, robot_us: int, now_s: float) -> float:
        if not self.ready:
            return robot_us / 1e6
        expected_us = round((now_s + self.offset_s(now_s)) * 1e6)
        return (expected_us + _short_us(robot_us - expected_us)) / 1e6

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


def _short_us(difference_us: int) -> int:
    """Shorter difference of two clocks modulo 2**32."""
    return (difference_us + WRAP_US // 2) % WRAP_US - WRAP_US // 2
