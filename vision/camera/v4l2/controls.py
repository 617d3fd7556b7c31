"""A camera's exposure, gain, focus, white balance and mains frequency, set and read back.

Rules and units
- ``auto`` or a number: exposure in milliseconds, white balance in kelvin, gain and focus in the
  driver's own units, mains 50 or 60 Hz.
- A driver refuses a value while its automatic function works, so that is switched first. Automatic
  exposure may never lower the rate.
- A setting that a driver lacks, refuses or rounds becomes a sentence.

Source: linux/v4l2-controls.h.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from vision.camera.v4l2 import structs
from vision.camera.v4l2.node import Node

Auto: TypeAlias = float | Literal["auto"]

GAIN, AUTO_GAIN = 0x00980913, 0x00980912
EXPOSURE, AUTO_EXPOSURE, DYNAMIC_RATE = 0x009A0902, 0x009A0901, 0x009A0903
FOCUS, AUTO_FOCUS = 0x009A090A, 0x009A090C
WHITE_BALANCE, AUTO_WHITE_BALANCE = 0x0098091A, 0x0098090C
MAINS: Final = 0x00980918

_DISABLED, _READ_ONLY = 0x1, 0x4
_NEXT: Final = 0x80000000
_MENU: Final = 3
_MOST_LISTED: Final = 1000
EXPOSURE_UNIT_MS: Final = 0.1
_BY_HAND: Final = (1, 2)
"""Menu of automatic exposure: manual, and shutter priority (time by hand, iris automatic)."""
_BY_ITSELF: Final = (3, 0)
"""Aperture priority (iris by hand, as webcams have none), and all automatic."""
_MAINS_MENU: Final = {50: 1, 60: 2}


@dataclass(frozen=True, slots=True)
class CameraControls:
    """Settings that the configuration requests of a camera."""

    exposure_ms: Auto = "auto"
    gain: Auto = "auto"
    focus: Auto = "auto"
    white_balance_k: Auto = "auto"
    mains_hz: int = 50


@dataclass(frozen=True, slots=True)
class CameraControl:
    """A control of the camera, in the driver's units; ``menu`` has the choices' texts."""

    id: int
    name: str
    least: int
    most: int
    step: int
    default: int
    value: int | None
    menu: tuple[tuple[int, str], ...] = ()


def list_controls(node: Node) -> list[CameraControl]:
    """List every control that can be set."""
    return list(_listed(node))


def _listed(node: Node) -> Iterator[CameraControl]:
    after = 0
    for _ in range(_MOST_LISTED):
        reply = node.try_ask(structs.QUERYCTRL, structs.ControlQuery(id=after | _NEXT))
        if reply is None or reply.id <= after:
            return
        after = int(reply.id)
        if reply.flags & _DISABLED or reply.flags & _READ_ONLY:
            continue
        if reply.type not in (1, 2, _MENU):  # numbers, switches, menus; others are titles
            continue
        menu = tuple(_menu(node, reply)) if reply.type == _MENU else ()
        name = reply.name.decode("utf-8", "replace")
        yield CameraControl(
            after, name, reply.minimum, reply.maximum, max(1, reply.step), reply.default_value,
            _read(node, after), menu,
        )  # fmt: skip


def _menu(node: Node, of: structs.ControlQuery) -> Iterator[tuple[int, str]]:
    for index in range(max(0, of.minimum), min(of.maximum, 255) + 1):
        reply = node.try_ask(structs.QUERYMENU, structs.ControlMenu(id=of.id, index=index))
        if reply is not None:
            yield index, reply.label.name.decode("utf-8", "replace")


def _read(node: Node, control: int) -> int | None:
    try:
        reply = node.ask(structs.G_CTRL, structs.Control(id=control))
    except OSError:
        return None  # write only, or inactive
    return int(reply.value)


def set_controls(node: Node, wanted: CameraControls) -> list[str]:
    """Set and read back; return a sentence for each setting not as requested."""
    return _Setting(node).all(wanted)


class _Setting:
    def __init__(self, node: Node) -> None:
        self._node = node
        self._has = {one.id: one for one in list_controls(node)}
        self.said: list[str] = []

    def all(self, wanted: CameraControls) -> list[str]:
        self._mains(wanted.mains_hz)
        self._exposure(wanted.exposure_ms)
        self._switched("gain", AUTO_GAIN, GAIN, wanted.gain)
        self._switched("focus", AUTO_FOCUS, FOCUS, wanted.focus)
        self._switched("white_balance_k", AUTO_WHITE_BALANCE, WHITE_BALANCE, wanted.white_balance_k)
        return self.said

    def _mains(self, mains_hz: int) -> None:
        """Set the mains frequency; without the control no complaint, as 50 is the default."""
        if MAINS in self._has:
            self._set("mains_hz", mains_hz, MAINS, _MAINS_MENU[mains_hz], lambda _: "another")

    def _exposure(self, wanted_ms: Auto) -> None:
        switch = self._has.get(AUTO_EXPOSURE)
        choices = _BY_ITSELF if wanted_ms == "auto" else _BY_HAND
        if switch is not None:
            offered = [index for index, _ in switch.menu] or list(choices)
            found = next((choice for choice in choices if choice in offered), None)
            if found is not None:
                self._set("exposure_ms", wanted_ms, AUTO_EXPOSURE, found, _another_mode)
            elif wanted_ms == "auto":
                self.said.append("exposure_ms: the camera has no automatic exposure")
        if wanted_ms != "auto":
            self._number("exposure_ms", wanted_ms, EXPOSURE, EXPOSURE_UNIT_MS)
        elif DYNAMIC_RATE in self._has:
            self._set("exposure_ms", "auto that keeps the rate", DYNAMIC_RATE, 0, _another_mode)

    def _switched(self, key: str, switch: int, value: int, wanted: Auto) -> None:
        if switch in self._has:
            self._set(key, wanted, switch, int(wanted == "auto"), _another_mode)
        if wanted != "auto":
            self._number(key, wanted, value, 1.0)

    def _number(self, key: str, wanted: float, control: int, unit: float) -> None:
        has = self._has.get(control)
        if has is None:
            self.said.append(f"asked for {key} {wanted:g}, the camera has no such control")
            return
        asked = round(wanted / unit)
        if not has.least <= asked <= has.most:
            least, most = has.least * unit, has.most * unit
            self.said.append(f"asked for {key} {wanted:g}, the camera has {least:g} to {most:g}")
            asked = min(max(asked, has.least), has.most)
        steps = round((asked - has.least) / has.step)
        asked = min(has.most, has.least + has.step * steps)
        self._set(key, wanted, control, asked, lambda got: f"{got * unit:g}")

    def _set(
        self, key: str, wanted: object, control: int, value: int, words: Callable[[int], str]
    ) -> None:
        shown = f"{wanted:g}" if isinstance(wanted, float) else f"{wanted}"
        try:
            self._node.ask(structs.S_CTRL, structs.Control(id=control, value=value))
        except OSError as error:
            reason = error.strerror or error
            self.said.append(f"asked for {key} {shown}, the driver refuses ({reason})")
            return
        got = _read(self._node, control)
        if got is not None and got != value:
            self.said.append(f"asked for {key} {shown}, the driver gives {words(got)}")


def _another_mode(got: int) -> str:
    return f"mode {got}"
