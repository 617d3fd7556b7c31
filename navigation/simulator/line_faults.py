"""Effects of a bad cable on bytes, on order: drop, flip, dup, swap, span, noise, stall.

A specification is a comma-separated list, as ``drop=0.001,flip=0.0005,stall=0.1@5``:

- ``drop=P`` loses a byte with probability P; ``flip=P`` turns one of its bits
- ``noise=P`` inserts a random byte before it
- ``dup=P``, ``swap=P``, ``span=P`` act on frames: sent twice, sent after the next one, or 4 to 40
  bytes of it lost
- ``stall=S@T`` for S seconds out of every T nothing passes, then all of it at once
- ``reset=T``, ``freeze=S@T`` restart the robot's processor, or halt it for S seconds, T seconds
  after the start
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


class FaultSpecError(ValueError):
    """A fault specification is invalid; the message names the part and the reason."""


@dataclass(frozen=True, slots=True)
class FaultSpec:
    """Probabilities per byte (drop, flip, noise) and per frame, times in seconds."""

    drop: float = 0.0
    flip: float = 0.0
    noise: float = 0.0
    dup: float = 0.0
    swap: float = 0.0
    span: float = 0.0
    stall_s: float = 0.0
    stall_every_s: float = math.inf
    reset_at_s: float = math.inf
    freeze_s: float = 0.0
    freeze_at_s: float = math.inf

    @classmethod
    def parse(cls, text: str) -> FaultSpec:
        """Read a specification as in the module's text; FaultSpecError if invalid."""
        values: dict[str, float] = {}
        for part in filter(None, (part.strip() for part in text.split(","))):
            name, equals, value = part.partition("=")
            if not equals:
                raise FaultSpecError(f"fault '{part}': must be NAME=VALUE, as drop=0.001")
            for key, number in _read(name.strip(), value.strip()):
                if key in values:
                    raise FaultSpecError(f"fault '{name.strip()}': given twice")
                values[key] = number
        return cls(**values)


_RATES = ("drop", "flip", "noise", "dup", "swap", "span")
_TIMED = {"stall": ("stall_s", "stall_every_s"), "freeze": ("freeze_s", "freeze_at_s")}


def _read(name: str, value: str) -> list[tuple[str, float]]:
    if name in _RATES:
        rate = _number(name, value)
        if not 0.0 <= rate <= 1.0:
            raise FaultSpecError(f"fault {name}={value}: must be a probability in [0, 1]")
        return [(name, rate)]
    if name == "reset":
        return [("reset_at_s", _positive(name, value))]
    if name in _TIMED:
        first, at, second = value.partition("@")
        if not at:
            raise FaultSpecError(f"fault {name}={value}: must be SECONDS@SECONDS, as 0.1@5")
        keys = _TIMED[name]
        return [(keys[0], _positive(name, first)), (keys[1], _positive(name, second))]
    known = ", ".join([*_RATES, *_TIMED, "reset"])
    raise FaultSpecError(f"fault '{name}': unknown; there are {known}")


def _number(name: str, value: str) -> float:
    try:
        return float(value)
    except ValueError:
        raise FaultSpecError(f"fault {name}={value}: '{value}' is not a number") from None


def _positive(name: str, value: str) -> float:
    number = _number(name, value)
    if not 0.0 < number < math.inf:
        raise FaultSpecError(f"fault {name}={value}: must be > 0 and finite")
    return number


class FaultyLine:
    """One direction of a bad line; :meth:`carry` turns sent bytes into received ones."""

    def __init__(self, spec: FaultSpec, rng: np.random.Generator) -> None:
        self.spec = spec
        self._rng = rng
        self._frame = bytearray()
        self._kept = b""
        self.held = bytearray()
        """Bytes that a stall keeps back."""
        per_frame = (spec.dup, spec.swap, spec.span)
        self._by_frame = any(rate > 0.0 for rate in per_frame)

    def carry(self, data: bytes, now_s: float) -> bytes:
        """Return the bytes that arrive; call with ``b""`` too, to end a stall."""
        if data and self._by_frame:
            data = self._damage_frames(data)
        if data:
            data = self._damage_bytes(data)
        if self.spec.stall_s == 0.0:
            return data
        self.held += data
        if now_s % self.spec.stall_every_s < self.spec.stall_s:
            return b""
        data = bytes(self.held)
        self.held.clear()
        return data

    def _damage_frames(self, data: bytes) -> bytes:
        out = bytearray()
        for value in data:
            self._frame.append(value)
            if value == 0 and len(self._frame) > 1:
                out += self._damage_frame(bytes(self._frame))
                self._frame.clear()
        return bytes(out)

    def _damage_frame(self, frame: bytes) -> bytes:
        spec, rng = self.spec, self._rng
        if rng.random() < spec.span:
            start = int(rng.integers(len(frame)))
            frame = frame[:start] + frame[start + int(rng.integers(4, 41)) :]
        if rng.random() < spec.dup:
            frame += frame
        kept, self._kept = self._kept, b""
        if kept:
            return frame + kept
        if rng.random() < spec.swap:
            self._kept = frame
            return b""
        return frame

    def _damage_bytes(self, data: bytes) -> bytes:
        spec, rng = self.spec, self._rng
        if not (spec.drop or spec.flip or spec.noise):
            return data
        raw = np.frombuffer(data, dtype=np.uint8).copy()
        flipped = rng.random(len(raw)) < spec.flip
        raw[flipped] ^= (1 << rng.integers(0, 8, int(flipped.sum()))).astype(np.uint8)
        raw = raw[rng.random(len(raw)) >= spec.drop]
        noisy = np.flatnonzero(rng.random(len(raw)) < spec.noise)
        if len(noisy):
            raw = np.insert(raw, noisy, rng.integers(0, 256, len(noisy), dtype=np.uint8))
        return raw.tobytes()
