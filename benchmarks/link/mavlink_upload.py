"""A peer of the link: pymavlink's mission upload over the same paced and faulty line.

MAVLink's mission protocol as its specification has it: the vehicle asks for one item after the
other, again after 250 ms without an answer and up to five times, and acknowledges the last. Both
ends run on pymavlink's parser and packer, in virtual time, with answers that take no time at all,
which is kinder than any real vehicle. As on our link, the vehicle reports its position and the
ground its life 20 times a second. pymavlink is no dependency: ``pip install pymavlink``.
"""

from __future__ import annotations

import importlib.util
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from navigation.simulator.line_faults import FaultSpec, FaultyLine
from navigation.simulator.virtual_loop import PacedLine

TICK_S = 0.0002
ASK_AGAIN_S = 0.25
TRIES = 6
"""The first and five retries."""
PATIENCE_S = 120.0
REPORT_S = 0.05


@dataclass(frozen=True, slots=True)
class UploadResult:
    """What became of an upload."""

    waypoints_s: float
    """Waypoints a second until it ended, one way or the other."""
    taken: int
    wanted: int
    wrong: int
    """Items taken that are not those sent."""
    asked_again: int

    def sentence(self) -> str:
        """The outcome in words."""
        whole = "whole" if self.taken == self.wanted else f"given up at {self.taken}"
        wrong = f", {self.wrong} wrong" if self.wrong else ""
        return f"{self.waypoints_s:.0f} ({whole}, {self.asked_again} asked again{wrong})"


def missing() -> bool:
    """Whether pymavlink is not installed."""
    return importlib.util.find_spec("pymavlink") is None


class _Outbox:
    """What a MAVLink object writes to."""

    def __init__(self) -> None:
        self.data = b""

    def write(self, data: bytes) -> None:
        self.data += bytes(data)

    def take(self) -> bytes:
        data, self.data = self.data, b""
        return data


class _Vehicle:
    """Asks for the items one by one."""

    def __init__(self, mav: Any, out: _Outbox) -> None:
        self.mav, self.out = mav, out
        self.items: list[Any] = []
        self.count = 0
        self.asked_s = math.inf
        self.tries = self.asked_again = 0
        self.failed = False

    def receive(self, message: Any, now_s: float) -> None:
        kind = message.get_type()
        if kind == "MISSION_COUNT" and not self.count:
            self.count = message.count
            self.ask(now_s)
        elif kind == "MISSION_ITEM_INT" and message.seq == len(self.items) < self.count:
            self.items.append(message)
            self.tries = 0
            if len(self.items) < self.count:
                self.ask(now_s)
            else:
                self.asked_s = math.inf
                self.mav.mission_ack_send(255, 0, 0)

    def ask(self, now_s: float) -> None:
        self.asked_s = now_s
        self.tries += 1
        self.mav.mission_request_int_send(255, 0, len(self.items))

    def tick(self, now_s: float) -> None:
        if now_s - self.asked_s >= ASK_AGAIN_S:
            if self.tries >= TRIES:
                self.failed = True
                return
            self.asked_again += 1
            self.ask(now_s)


def upload(count: int, faults: str, seed: int, baud: int = 115_200) -> UploadResult:
    """Upload ``count`` waypoints; needs pymavlink."""
    from pymavlink.dialects.v20 import common

    ends = []
    for system in (255, 1):
        out = _Outbox()
        mav = common.MAVLink(out, srcSystem=system)
        mav.robust_parsing = True
        ends.append((mav, out))
    (ground, from_ground), (craft, from_craft) = ends
    vehicle = _Vehicle(craft, from_craft)
    rng, spec = np.random.default_rng(seed), FaultSpec.parse(faults)
    down, up = PacedLine(baud), PacedLine(baud)
    damage = (FaultyLine(spec, rng), FaultyLine(spec, rng))
    now_s, counted_s, reported_s = 0.0, -math.inf, 0.0
    while len(vehicle.items) < count and not vehicle.failed and now_s < PATIENCE_S:
        now_s += TICK_S
        if not vehicle.count and now_s - counted_s >= ASK_AGAIN_S:
            counted_s = now_s
            ground.mission_count_send(1, 0, count)
        if now_s - reported_s >= REPORT_S:
            reported_s = now_s
            ground.heartbeat_send(6, 8, 0, 0, 4)
            craft.local_position_ned_send(int(1e3 * now_s), 0.1, 0.2, 0.0, 0.3, 0.0, 0.0)
        for message in craft.parse_buffer(damage[0].carry(down.take(now_s), now_s)) or []:
            vehicle.receive(message, now_s)
        vehicle.tick(now_s)
        for message in ground.parse_buffer(damage[1].carry(up.take(now_s), now_s)) or []:
            if message.get_type() == "MISSION_REQUEST_INT":
                ground.mission_item_int_send(1, 0, *_item(message.seq))
        for out, line in ((from_ground, down), (from_craft, up)):
            data = out.take()
            if data:
                line.put(data, now_s)
    wrong = sum(_fields(item) != _item(number) for number, item in enumerate(vehicle.items))
    taken = len(vehicle.items)
    return UploadResult(taken / now_s, taken, count, wrong, vehicle.asked_again)


def _item(number: int) -> tuple[float, ...]:
    """A waypoint in the local frame, fields in the message's order behind the target."""
    return (number, 1, 16, 0, 1, 0.0, 0.005, 0.0, 0.0, 1000 * number, -500 * number, 0.0)


def _fields(item: Any) -> tuple[float, ...]:
    """The same of a message that came."""
    head = (item.seq, item.frame, item.command, item.current, item.autocontinue)
    return (
        *head,
        item.param1,
        round(item.param2, 6),
        item.param3,
        item.param4,
        item.x,
        item.y,
        item.z,
    )
