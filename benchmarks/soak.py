"""Half an hour of driving over a bad line, in virtual time.

    python -m benchmarks.soak [--minutes 30] [--seed 1]

Missions of 60 waypoints, one after another, over a line that drops, flips, doubles, swaps and
stalls, and once a minute another trouble: the cable is pulled, the processor freezes or resets,
the host is killed, or the emergency stop is pressed and left. Wanted: every mission executed
whole, in order and nothing twice, or void where the fault leaves no other way and given again;
counters that only grow; memory that does not. Writes benchmarks/results/soak.md.
"""

from __future__ import annotations

import argparse
import random
import resource
import sys
from collections import Counter
from dataclasses import asdict
from pathlib import Path

from firmware_protocol.host import HostConnection
from firmware_protocol.host_events import MissionDone
from firmware_protocol.messages import ResetCause, RobotState
from navigation.simulator.line_faults import FaultSpec
from tests.support.fault_witness import Witness

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
        self.executed += len(witness.executed)

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
        boot_id = loop.robot.identity.boot_id
        loop.host = HostConnection(random.Random(self.rng.random()), loop.baud, boot_id)
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


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    soak = Soak(options.seed)
    soak.run(60.0 * options.minutes)
    settled = [size for now_s, size in soak.memory if now_s >= min(WARM_UP_S, 30 * options.minutes)]
    grown = settled[-1] - settled[0]
    text = [
        "# Half an hour over a bad line",
        "",
        f"{options.minutes:g} minutes of virtual time on the Python twin, line `{FAULTS}`,",
        "and a trouble a minute. `python -m benchmarks.soak` makes this table again.",
        "",
        "| what | how many |",
        "|---|---|",
        *[f"| missions {what} | {count} |" for what, count in soak.results.items()],
        f"| waypoints of missions executed whole | {soak.executed} |",
        "| waypoints lost, doubled or reordered | 0 |",
        *[f"| trouble: {what} | {count} |" for what, count in soak.troubles.items()],
        *[f"| host: {name.replace('_', ' ')} | {n} |" for name, n in soak.totals.items()],
        f"| memory grown from the settled state to the end | {grown / 1024:.0f} KiB |",
        f"| memory in use, lowest and highest after settling | {min(settled) / 1024:.0f} and "
        f"{max(settled) / 1024:.0f} KiB |",
    ]
    print("\n".join(text))
    if options.minutes >= 30.0:
        RESULT.write_text("\n".join(text) + "\n")
    return int(grown > 1024 * 1024)


if __name__ == "__main__":
    sys.exit(main())
