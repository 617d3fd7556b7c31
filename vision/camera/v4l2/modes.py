"""Modes that a camera can deliver, ranked: pixel format, size, rate.

Rules and units
- A mode is a pixel format, a size in pixels and its rates, frames a second.
- Modes of the requested or nearest size come first, then those that reach the rate, or the fastest,
  then raw pictures before packed ones, as nothing is lost or decoded, then grey.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from vision.camera.v4l2 import structs
from vision.camera.v4l2.node import Node

Size: TypeAlias = tuple[int, int]
Wanted: TypeAlias = Literal["auto", "mjpg", "yuyv", "grey"]

REACHES: Final = 0.95
"""Share of the requested rate that is enough: 29.97 for 30."""
MOST_LISTED: Final = 1000
"""Most formats, sizes or rates of a list."""
ORDER: Final = (
    *("GREY", "YUYV", "UYVY", "YVYU", "NV12", "NV21", "YU12", "YV12"),
    *("BGR3", "RGB3", "MJPG", "JPEG", "RGGB", "BA81", "GBRG", "GRBG"),
)
"""Pixel formats that `vision.camera.v4l2.pixels` reads, the best first. A sensor's mosaic comes
last: its colours are not balanced."""
_NAMED: Final = {"mjpg": ("MJPG", "JPEG"), "yuyv": ("YUYV", "UYVY", "YVYU"), "grey": ("GREY",)}
PACKED: Final = frozenset(("MJPG", "JPEG"))


@dataclass(frozen=True, slots=True)
class CameraMode:
    """Pixel format by its four letters, size, and rates, fastest first (may be empty)."""

    fourcc: str
    size: Size
    rates_hz: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Choice:
    """Request to the driver; ``rate_hz`` is None if neither it nor the caller names one."""

    fourcc: str
    size: Size
    rate_hz: float | None


def rank_modes(
    modes: Sequence[CameraMode], size: Size, rate_hz: float | None, wanted: Wanted = "auto"
) -> list[Choice]:
    """Rank the modes, best first; empty if none has a known and requested format."""
    allowed = ORDER if wanted == "auto" else _NAMED[wanted]
    known = [mode for mode in modes if mode.fourcc in allowed]

    def rank(mode: CameraMode) -> tuple[float, bool, float, int]:
        choice = _rate_of(mode, rate_hz)
        enough = rate_hz is None or choice is None or choice >= REACHES * rate_hz
        slow = 0.0 if enough or choice is None else -choice
        return _distance(mode.size, size), not enough, slow, ORDER.index(mode.fourcc)

    return [Choice(m.fourcc, m.size, _rate_of(m, rate_hz)) for m in sorted(known, key=rank)]


def rate_text(rate_hz: float) -> str:
    """Rate for people: 30, 7.5, 29.97."""
    return f"{rate_hz:.2f}".rstrip("0").rstrip(".")


def _rate_of(mode: CameraMode, rate_hz: float | None) -> float | None:
    """Slowest sufficient rate of a mode, otherwise its fastest."""
    if rate_hz is None or not mode.rates_hz:
        return mode.rates_hz[0] if mode.rates_hz else rate_hz
    enough = [rate for rate in mode.rates_hz if rate >= REACHES * rate_hz]
    return min(enough, default=max(mode.rates_hz))


def _distance(a: Size, b: Size) -> float:
    """Difference between two sizes; too small counts twice."""
    sides = zip(a, b, strict=True)
    return float(sum((2 if have < want else 1) * abs(have - want) for have, want in sides))


def list_modes(node: Node, size: Size | None = None) -> list[CameraMode]:
    """List a camera's modes; of a range of sizes its ends and, if inside, ``size``."""
    found = []
    for fourcc in _formats(node):
        sizes = list(dict.fromkeys(_sizes(node, fourcc, size)))
        # a driver that lists no sizes has at least one: try the requested one
        for each in sizes or ([size] if size else []):
            found.append(CameraMode(fourcc, each, _rates(node, fourcc, each)))
    return found


def fourcc_text(code: int) -> str:
    """Four letters of a pixel format's number."""
    return code.to_bytes(4, "little").decode("latin-1").rstrip()


def fourcc_code(text: str) -> int:
    """Number of a pixel format's four letters."""
    return int.from_bytes(text.ljust(4).encode("latin-1"), "little")


def _formats(node: Node) -> Iterator[str]:
    for index in range(MOST_LISTED):
        question = structs.FormatDescription(index=index, type=structs.CAPTURE)
        reply = node.try_ask(structs.ENUM_FMT, question)
        if reply is None:
            return
        yield fourcc_text(reply.pixelformat)


def _sizes(node: Node, fourcc: str, wanted: Size | None) -> Iterator[Size]:
    for index in range(MOST_LISTED):
        question = structs.FrameSizes(index=index, pixel_format=fourcc_code(fourcc))
        reply = node.try_ask(structs.ENUM_FRAMESIZES, question)
        if reply is None:
            return
        if reply.type == 1:  # one size; other types are ranges
            yield int(reply.sides[0]), int(reply.sides[1])
            continue
        left, right, across, low, high, down = (int(side) for side in reply.sides)
        yield right, high
        yield left, low
        wide, tall = wanted or (0, 0)
        if _in_steps(wide, left, right, across) and _in_steps(tall, low, high, down):
            yield wide, tall
        return


def _in_steps(value: int, least: int, most: int, step: int) -> bool:
    return least <= value <= most and (value - least) % max(1, step) == 0


def _rates(node: Node, fourcc: str, size: Size) -> tuple[float, ...]:
    return tuple(sorted(set(_rates_listed(node, fourcc, size)), reverse=True))


def _rates_listed(node: Node, fourcc: str, size: Size) -> Iterable[float]:
    for index in range(MOST_LISTED):
        question = structs.FrameIntervals(
            index=index, pixel_format=fourcc_code(fourcc), width=size[0], height=size[1]
        )
        reply = node.try_ask(structs.ENUM_FRAMEINTERVALS, question)
        if reply is None:
            return
        spans = reply.spans[:1] if reply.type == 1 else reply.spans[:2]
        yield from (s.denominator / s.numerator for s in spans if s.numerator and s.denominator)
        if reply.type != 1:
            return
