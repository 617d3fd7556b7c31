"""Attacks on the camera: a network camera that lies, lags, freezes and dies."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from benchmarks.adversary.attacks.attack import Act, Attack
from benchmarks.adversary.processes import ProcessError
from benchmarks.adversary.rig import Needs, Rig

WATCH_S = 7.5
ROOM_M = 0.09
"""What braking from full speed takes."""
LAID_AHEAD_M, LAID_LONG_M, LAID_WIDE_M = 0.38, 0.12, 0.01
"""From the robot's middle; the bar is 30 x 2.5 pixels of the camera's."""
LAID_WITHIN_S = 20.0
HTTP = Needs(http_camera=True)
HANDLED = Needs(http_camera=True, handled=True)


def _shows(seconds: float = WATCH_S, **faults: Any) -> Act:
    def act(rig: Rig) -> None:
        rig.show(**faults)
        rig.watch_mission(seconds)

    return act


def _place(rig: Rig, least_m: float, most_m: float) -> tuple[float, float, float]:
    """A free place so far from where the robot is, by the rig's own chance.

    With room to brake: a robot that is put down in full drive has a right to it.
    """
    assert rig.truth.pose is not None
    x, y, _ = rig.truth.pose
    x0, y0, x1, y1 = rig.config.arena.bounds_m
    while True:
        place = (float(rig.rng.uniform(x0, x1)), float(rig.rng.uniform(y0, y1)))
        free = float(rig.truth.arena.clearances([place])[0]) > rig.truth.radius_m + ROOM_M
        if free and least_m <= math.dist(place, (x, y)) <= most_m:
            return (*place, float(rig.rng.uniform(-math.pi, math.pi)))


def _off(rig: Rig, metres: float) -> tuple[float, float]:
    """So far (x, y) from the robot, in a direction in which it would stand free."""
    assert rig.truth.pose is not None
    x, y, _ = rig.truth.pose
    free: list[tuple[float, tuple[float, float]]] = []
    for turn_rad in rig.rng.uniform(-math.pi, math.pi, 60):
        off = (metres * math.cos(turn_rad), metres * math.sin(turn_rad))
        clearance = float(rig.truth.arena.clearances([(x + off[0], y + off[1])])[0])
        if clearance > rig.truth.radius_m + ROOM_M / 2:
            return off
        free.append((clearance, off))
    return max(free)[1]


def _covered_with_a_double(rig: Rig) -> None:
    rig.show(covered=True, double_at=_place(rig, 0.3, 0.8))
    rig.watch_mission(WATCH_S)


def _double_beside(rig: Rig) -> None:
    rig.show(double_at=_place(rig, 0.25, 0.6))
    rig.watch_mission(WATCH_S)


def _swapped_for_good(rig: Rig) -> None:
    rig.show(shown_at=_place(rig, 0.3, 0.8))
    rig.watch_mission(WATCH_S)


def _swapped_now_and_then(rig: Rig) -> None:
    rig.show(shown_at=_place(rig, 0.3, 0.8), every=5)
    rig.watch_mission(WATCH_S)


def _jump(rig: Rig) -> None:
    rig.show(lie_m=_off(rig, 0.5))
    rig.watch_mission(WATCH_S)


def _small_jump(rig: Rig) -> None:
    rig.show(lie_m=_off(rig, 0.08))
    rig.watch_mission(WATCH_S)


def _drift(metres_s: float) -> Act:
    def act(rig: Rig) -> None:
        rig.show(lie_m=_off(rig, 0.3), lie_m_s=metres_s)
        rig.watch_mission(12.0)

    return act


def _dies_and_returns(rig: Rig) -> None:
    rig.show(dead=True)
    rig.watch(3.0)
    rig.show()
    rig.watch_mission(5.0)
    rig.show(dead=True)
    rig.watch(1.5)


def _stalls(rig: Rig) -> None:
    for seconds in (0.4, 1.5, 3.0):
        rig.show(stalled=True)
        rig.watch(seconds)
        rig.show()
        rig.watch(1.0)
    rig.show(stalled=True)
    rig.watch(1.0)


def _carried(rig: Rig) -> None:
    """Lifted, and put down elsewhere, in sight of the camera."""
    rig.carry(_place(rig, 0.3, 0.8), 0.5)
    rig.watch_mission(WATCH_S)


def _carried_unseen(rig: Rig) -> None:
    """The same while the camera stalls for a moment."""
    rig.show(stalled=True)
    rig.carry(_place(rig, 0.3, 0.8), 0.5)
    rig.watch(0.6)
    rig.show()
    rig.watch_mission(WATCH_S)


def _turned_by_hand(rig: Rig) -> None:
    assert rig.truth.pose is not None
    x, y, heading_rad = rig.truth.pose
    rig.carry((x, y, heading_rad + math.pi), 0.4)
    rig.watch_mission(WATCH_S)


def _stuck(grip: float, seconds: float) -> Act:
    def act(rig: Rig) -> None:
        rig.grip(grip)
        rig.watch_mission(seconds, however_long=True)
        rig.note_end()
        rig.grip(1.0)
        rig.watch_mission(4.0)

    return act


def _pushed_camera(rig: Rig) -> None:
    turn_rad = float(rig.rng.uniform(-math.pi, math.pi))
    rig.show(moved_m=(0.03 * math.cos(turn_rad), 0.03 * math.sin(turn_rad)))
    rig.watch_mission(WATCH_S)


def _laid_in_the_way(rig: Rig) -> None:
    """A faint bar across the robot's heading, where it has room to brake; the camera sees it."""
    deadline_s = time.monotonic() + LAID_WITHIN_S
    while time.monotonic() < deadline_s and rig.watch(0.05):
        assert rig.truth.pose is not None
        x, y, heading_rad = rig.truth.pose
        ahead = np.array([math.cos(heading_rad), math.sin(heading_rad)])
        across = np.array([-ahead[1], ahead[0]])
        middle = np.array([x, y]) + LAID_AHEAD_M * ahead
        along_m, wide_m = 0.5 * LAID_LONG_M * across, 0.5 * LAID_WIDE_M * ahead
        half_m = [along_m + wide_m, along_m - wide_m, -along_m - wide_m, wide_m - along_m]
        corners_m = middle + np.array(half_m)
        far_m = np.hypot(*(rig.truth.rows()[:, 1:3] - middle).T).min() - 0.5 * LAID_LONG_M
        is_free = float(rig.truth.arena.clearances(corners_m).min()) > ROOM_M / 2
        if is_free and far_m > rig.truth.radius_m + ROOM_M:
            rig.truth.lay(corners_m)
            rig.show(laid=corners_m.ravel().tolist())
            break
    else:
        raise ProcessError("there was no free floor ahead of the robot to lay a bar on")
    rig.watch_mission(2.0 * WATCH_S)


def _late(latency_s: float) -> Attack:
    return Attack("camera", f"pictures {latency_s:g} s late", _shows(latency_s=latency_s), HTTP)


ATTACKS = (
    Attack("camera", "nothing is wrong", _shows(), HTTP),
    Attack("camera", "a faint bar laid in the way", _laid_in_the_way, HTTP, (0.05, 0.3)),
    Attack("camera", "frozen, to the bit", _shows(frozen="exact"), HTTP),
    Attack("camera", "frozen with a running clock", _shows(frozen="clock"), HTTP),
    Attack("camera", "frozen with fresh noise", _shows(frozen="noise"), HTTP),
    *[_late(latency_s) for latency_s in (0.1, 0.3, 0.6, 1.0, 1.5)],
    Attack("camera", "marker covered, its double elsewhere", _covered_with_a_double, HTTP),
    Attack("camera", "its double beside the marker", _double_beside, HTTP),
    Attack("camera", "pictures with the robot elsewhere", _swapped_for_good, HTTP),
    Attack("camera", "every fifth picture swapped so", _swapped_now_and_then, HTTP),
    Attack("camera", "the last 3 s again and again", _shows(loop_s=3.0), HTTP, (0.4, 0.7)),
    Attack("camera", "the marker turned by 180 degrees", _shows(turned=True), HTTP),
    Attack("camera", "a jump of 0.5 m that stays", _jump, HTTP),
    Attack("camera", "a jump of 0.08 m that stays", _small_jump, HTTP),
    Attack("camera", "a drift of 0.3 m at 3 cm/s", _drift(0.03), HTTP),
    Attack("camera", "a drift of 0.3 m at 10 cm/s", _drift(0.10), HTTP),
    Attack("camera", "hidden for 0.3 s in 1 s", _shows(blink=(0.7, 0.3)), HTTP),
    Attack("camera", "hidden for 2 s in 3 s", _shows(blink=(1.0, 2.0)), HTTP),
    Attack("camera", "the stream stalls", _stalls, HTTP),
    Attack("camera", "the stream dies and comes back", _dies_and_returns, HTTP),
    Attack("camera", "truncated pictures", _shows(5.0, truncated=True), HTTP),
    Attack("camera", "another size in mid-stream", _shows(5.0, size_px=(320, 240)), HTTP),
    Attack("camera", "carried by hand", _carried, HANDLED),
    Attack("camera", "carried while the stream stalls", _carried_unseen, HANDLED),
    Attack("camera", "turned round by hand", _turned_by_hand, HANDLED),
    Attack("camera", "stuck: the wheels spin", _stuck(0.0, 6.0), HANDLED),
    Attack("camera", "half the wheels' travel is slip", _stuck(0.5, 6.0), HANDLED),
    Attack("camera", "the camera pushed by 3 cm", _pushed_camera, HTTP),
)
