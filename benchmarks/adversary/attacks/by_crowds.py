"""Attacks by crowds: on the page's port and on the control socket. The stop comes in mid-flood."""

from __future__ import annotations

import resource

from benchmarks.adversary.attacks.attack import Act, Attack
from benchmarks.adversary.processes import Process, module
from benchmarks.adversary.rig import Needs, Rig

FLOOD_S = 14.0
BEFORE_STOP_S = 3.0
USUAL_FILES = 1024
"""How many files a service may open that says nothing about it."""
PAGE = Needs(page=True)


def _flood(kind: str, count: int) -> Act:
    def act(rig: Rig) -> None:
        hard = resource.prlimit(rig.daemon.popen.pid, resource.RLIMIT_NOFILE)[1]
        resource.prlimit(rig.daemon.popen.pid, resource.RLIMIT_NOFILE, (USUAL_FILES, hard))
        where = str(rig.socket) if kind in ("drip", "silent", "nonsense") else str(rig.page_port)
        words = (kind, where, str(count), str(FLOOD_S))
        crowd = rig.process(Process("crowd", module("crowd", *words), rig.folder))
        crowd.first_line(10.0)
        rig.watch(BEFORE_STOP_S)
        rig.stop()
        rig.watch(1.5)
        crowd.end()
        rig.watch(1.0)

    return act


ATTACKS = (
    Attack("flood", "1,100 half-open connections to the page", _flood("half_open", 1100), PAGE),
    Attack("flood", "64 viewers", _flood("viewers", 64), PAGE),
    Attack("flood", "40 dripping clients at the control socket", _flood("drip", 40)),
    Attack("flood", "40 silent clients at the control socket", _flood("silent", 40)),
    Attack("flood", "nonsense at the control socket", _flood("nonsense", 1000)),
)
