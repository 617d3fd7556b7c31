"""Half an hour of driving over a bad line, in virtual time.

    python -m benchmarks.soak [--minutes 30] [--seed 1] [--only TEXT]

Missions of 60 waypoints, one after another, over a line that drops, flips, doubles, swaps and
stalls, and once a minute another trouble: the cable is pulled, the processor freezes or resets,
the host is killed, or the emergency stop is pressed and left. Wanted: every mission executed
whole, in order and nothing twice, or void where the fault leaves no other way and given again;
counters that only grow; memory that does not. On the Python robot and on the firmware in C in this
process, one after the other. Writes benchmarks/results/soak.md.
"""

from __future__ import annotations

import argparse
import random
import resource
import sys
from collections import Counter
from dataclasses import asdict
from pathlib import Path

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import MissionDone
from firmware_protocol.wire.messages import ResetCause, RobotState
from navigation.simulator.line_faults import FaultSpec
from navigation.simulator.virtual_loop import python_robot
from tests.support.robots.c_robot import CRobot, missing_tool
from tests.support.wire.fault_witness import RobotMaker, Witness, robot_maker

RESULT = Path(__file__).parent / "results" / "soak.md"
FAULTS = "drop=0.001,flip=0.0005,noise=0.0005,span=0.003,dup=0.01,swap=0.01,stall=0.15@7"
WARM_UP_S = 300.0
"""Memory is compared from here on: tables and caches have been filled by then."""


def resident_bytes() -> int:
    """This process's memory, of Linux only."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize()


class Soak:
    """One robot and its host for a long time."""

    def __init__(self, seed: int) -> None:
        self.witness = Witness(seed, FaultSpec.parse(FAULTS), count=60)
        self.rng = random.Random(seed)
        self.troubles: Counter[str] = Counter()
        self.results: Counter[str] = Counter()
        self.executed = 0
        self.totals: Counter[str] = Counter()
        self.next_trouble_s = 60.0
        self.memory: list[tuple[float, int]] = []

    def run(self, seconds: float) -> None:
        loop = self.witness.loop
        while loop.now_s < seconds:
            self.mission()
            if not self.memory or loop.now_s - self.memory[-1][0] > 60.0:
                print(f"{loop.now_s:.0f} s {dict(self.results)}", file=sys.stderr, flush=True)
                self.memory.append((loop.now_s, resident_bytes()))
        self.keep_counters(loop.host)

    def mission(self) -> None:
        """One mission, given again under a new id where a fault has made it void."""
        witness, loop = self.witness, self.witness.loop
        witness.connect()
        loop.run(0.2)
        loop.events.clear()
        loop.track.clear()
        witness.given.clear()
        witness.executed.clear()
        witness.mission = witness.new_mission(self.rng.randrange(1, 1 << 32))
        witness.give()
        end_s = loop.now_s + 60.0
        while not loop.run(0.25, witness.is_done):
            assert loop.now_s < end_s, f"not done: {witness.describe()}"
            self.make_trouble()
            host = loop.host
            if host.upload_state is None:
                witness.judge_chain(whole=False)
                self.results["void, and said so"] += 1
                self.leave_estop()
                return
            if host.state.is_up and witness.state in (RobotState.HOLD, RobotState.IDLE):
                host.start(loop.now_s)
        witness.judge_chain(whole=True)
        assert loop.events.count(MissionDone(witness.mission.id)) == 1
        self.results["executed whole"] += 1
        self.executed += len(witness.mission)

    def make_trouble(self) -> None:
        loop = self.witness.loop
        if loop.now_s < self.next_trouble_s:
            return
        self.next_trouble_s = loop.now_s + 60.0
        kind = ("cable", "freeze", "reset", "kill", "estop")[sum(self.troubles.values()) % 5]
        self.troubles[kind] += 1
        getattr(self, kind)()

    def cable(self) -> None:
        self.witness.loop.knobs.cable = False
        self.witness.loop.run(2.0)
        assert not self.witness.loop.drive.moving
        self.witness.loop.knobs.cable = True
        self.witness.connect()

    def freeze(self) -> None:
        self.witness.loop.knobs.frozen = True
        self.witness.loop.run(0.1)
        self.witness.loop.knobs.frozen = False

    def reset(self) -> None:
        self.witness.judge_chain(whole=False)
        self.witness.boot(ResetCause.BROWN_OUT)
        self.witness.loop.run(2.0)
        assert not self.witness.executed

    def kill(self) -> None:
        """Another process takes over what the journal says of the mission."""
        loop = self.witness.loop
        self.keep_counters(loop.host)
        loop.host = HostConnection(random.Random(self.rng.random()), loop.baud)
        loop.host.open(loop.now_s)
        loop.host.upload(self.witness.mission, loop.now_s, start=False)
        self.witness.connect()

    def estop(self) -> None:
        loop = self.witness.loop
        loop.host.estop()
        assert loop.run(1.0, lambda: self.witness.state is RobotState.ESTOP)
        loop.run(0.3)

    def leave_estop(self) -> None:
        loop = self.witness.loop
        if self.witness.state is RobotState.ESTOP:
            loop.host.reset_estop(loop.now_s)
            assert loop.run(3.0, lambda: self.witness.state is not RobotState.ESTOP)

    def keep_counters(self, host: HostConnection) -> None:
        self.totals.update(asdict(host.counters))
        self.totals.update({f"parser {k}": v for k, v in asdict(host.parser.counters).items()})


ROBOTS: dict[str, RobotMaker] = {
    "Python": python_robot,
    "C": lambda identity, drive: CRobot(identity, drive),  # type: ignore[dict-item,return-value]
}


def soak_of(name: str, seed: int, minutes: float) -> tuple[Soak, list[int]]:
    """A robot's soak, and the memory once it has settled."""
    print(name, file=sys.stderr)
    token = robot_maker.set(ROBOTS[name])
    try:
        soak = Soak(seed)
        soak.run(60.0 * minutes)
    finally:
        robot_maker.reset(token)
    return soak, [size for now_s, size in soak.memory if now_s >= min(WARM_UP_S, 30 * minutes)]


def table(soaks: dict[str, tuple[Soak, list[int]]]) -> list[str]:
    """One column a robot."""
    rows: dict[str, dict[str, str]] = {}
    for name, (soak, settled) in soaks.items():
        counts = {
            **{f"missions {what}": n for what, n in soak.results.items()},
            "waypoints of missions executed whole": soak.executed,
            "waypoints lost, doubled or reordered": 0,
            **{f"trouble: {what}": n for what, n in soak.troubles.items()},
            **{f"host: {what.replace('_', ' ')}": n for what, n in soak.totals.items()},
            "memory grown from the settled state to the end, KiB": round(grown(settled) / 1024),
            "memory in use, lowest after settling, KiB": min(settled) // 1024,
            "memory in use, highest after settling, KiB": max(settled) // 1024,
        }
        for what, count in counts.items():
            rows.setdefault(what, {})[name] = str(count)
    head = [f"| what | {' | '.join(soaks)} |", "|---|" + "---|" * len(soaks)]
    return head + [
        f"| {what} | {' | '.join(found.get(name, '0') for name in soaks)} |"
        for what, found in rows.items()
    ]


def grown(settled: list[int]) -> int:
    """Bytes from the settled state to the end."""
    return settled[-1] - settled[0]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="robots whose name contains this")
    options = parser.parse_args()
    names = [name for name in ROBOTS if options.only in name]
    missing = missing_tool()
    if "C" in names and missing is not None:
        print(f"needs {missing} to build the firmware", file=sys.stderr)
        return 2
    soaks = {name: soak_of(name, options.seed, options.minutes) for name in names}
    text = [
        "# Half an hour over a bad line",
        "",
        f"{options.minutes:g} minutes of virtual time on each robot, line `{FAULTS}`,",
        "and a trouble a minute. `python -m benchmarks.soak` makes this table again.",
        "",
        *table(soaks),
    ]
    print("\n".join(text))
    if options.minutes >= 30.0 and len(names) == len(ROBOTS):
        RESULT.write_text("\n".join(text) + "\n")
    return int(any(grown(settled) > 1024 * 1024 for _, settled in soaks.values()))


if __name__ == "__main__":
    sys.exit(main())
