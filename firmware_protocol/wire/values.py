"""Conversion between SI units and the wire's integers: scaling, ranges, angles, sizes.

Values of this program raise LocalError, values from the wire RemoteError.
"""

from __future__ import annotations

import math
from enum import IntEnum
from struct import Struct
from typing import Final, TypeVar

from firmware_protocol.wire.errors import LocalError, RemoteError

UM_PER_M: Final = 1_000_000
HEADING_FREE: Final = -32768
"""Heading that means any."""
NO_POSE_MS: Final = 0xFFFF
"""Pose age that means none."""
_RADIAN: Final = 10_000
_HALF_TURN: Final = 31_416


def wrap_angle(angle_rad: float) -> float:
    """The same angle in (-pi, pi]."""
    wrapped = math.remainder(angle_rad, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


def scaled(name: str, value: float, scale: float, low: int, high: int) -> int:
    """The integer nearest to ``value * scale``; LocalError names the limits outside them."""
    if not math.isfinite(value):
        raise LocalError(f"{name} = {value}: must be finite")
    number = round(value * scale)
    if not low <= number <= high:
        raise LocalError(f"{name} = {value}: must be in [{low / scale:g}, {high / scale:g}]")
    return number


def to_um(name: str, value_m: float) -> int:
    """A position in micrometres."""
    return scaled(name, value_m, UM_PER_M, -0x7FFFFFFF, 0x7FFFFFFF)


def heading_to_wire(value_rad: float | None) -> int:
    """A heading in 1e-4 rad; None is any."""
    if value_rad is None:
        return HEADING_FREE
    if not math.isfinite(value_rad):
        raise LocalError(f"heading_rad = {value_rad}: must be finite")
    inside = value_rad if abs(value_rad) <= math.pi else wrap_angle(value_rad)
    return round(inside * _RADIAN)


def heading_from_wire(wire: int) -> float | None:
    """The heading in [-pi, pi], None for any; RemoteError beyond half a turn."""
    if wire == HEADING_FREE:
        return None
    if not -_HALF_TURN <= wire <= _HALF_TURN:
        raise RemoteError(f"heading {wire}: must be in [-{_HALF_TURN}, {_HALF_TURN}] or free")
    # the wire's last step lies just beyond half a turn
    return max(-math.pi, min(math.pi, wire / _RADIAN))


def clamped(value: float, scale: float, high: int) -> int:
    """Time clamped to ``high``, where excess does not matter."""
    if math.isnan(value) or value < 0.0:
        raise LocalError(f"time {value}: must be >= 0")
    return high if value * scale >= high else round(value * scale)


def unpack_exactly(what: str, layout: Struct, payload: bytes) -> tuple[int, ...]:
    """Fields of a payload; RemoteError if its size differs."""
    if len(payload) != layout.size:
        raise RemoteError(f"{what} of {len(payload)} bytes: must have {layout.size}")
    return layout.unpack(payload)


_Known = TypeVar("_Known", bound=IntEnum)


def known(enum: type[_Known], value: int) -> _Known:
    """The member with that number; RemoteError if there is none."""
    try:
        return enum(value)
    except ValueError:
        raise RemoteError(f"{enum.__name__} {value}: unknown") from None


def saturated(value: float, high: int) -> int:
    """Nearest integer within plus and minus ``high``, for reports, not orders."""
    return max(-high, min(high, round(value)))
