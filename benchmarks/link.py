"""The serial link's figures on the real AVR binary, emulated at its true baud rate.

    python -m benchmarks.link [--quick]

The firmware runs on an emulated ATmega328P (simavr) in lockstep with the host's end in virtual
time, so the figures depend on no machine. Writes benchmarks/results/link.md. Needs what
tests/support/avr_robot.py names. Parser speed is real time on this machine.
"""

from __future__ import annotations

import argparse
import math
import random
import statistics
import sys
import time
from pathlib import Path

import numpy as np

from firmware_protocol.framing import Frame, FrameParser, Sender, encode_frame
from firmware_protocol.host import HostConnection
from firmware_protocol.link import RttEstimate
from firmware_protocol.messages import MessageType, RobotState, Waypoint
from firmware_protocol.mission import Mission
from firmware_protocol.upload import BATCH
from navigation.simulator.emulated_processor import Motors
from navigation.simulator.line_faults import FaultSpec, FaultyLine
from tests.support.avr_robot import AvrRobot, missing_tools

RESULT = Path(__file__).parent / "results" / "link.md"
TICK_S = 0.001
LINE_BYTES_S = 11_520.0
LAG_S = 0.05


class Bench:
    """Host and emulated robot on one line, with simple motors behind the outputs."""

    def __init__(self, avr: AvrRobot, seed: int, faults: str = "") -> None:
        self.avr, self.now_s = avr, 0.0
        self.host = HostConnection(random.Random(seed))
        self.host.open(0.0)
        rng = np.random.default_rng(seed)
        spec = FaultSpec.parse(faults)
        self.lines = (FaultyLine(spec, rng), FaultyLine(spec, rng))
        self.waiting = b""
        self.speed = [0.0, 0.0]
        self.lease = True
        self.motors = Motors(0.0, 0.0, False, 0.0, 0.0)
        self.round_trips: list[float] = []
        self.tick(reset=True)

    def tick(self, reset: bool = False) -> None:
        """One millisecond."""
        travel = (self.speed[0] * TICK_S, self.speed[1] * TICK_S)
        self.motors, data = self.avr.run(TICK_S, self.waiting, travel, reset)
        for side in (0, 1):
            self.speed[side] += TICK_S / LAG_S * (self.motors[side] - self.speed[side])
        self.now_s += TICK_S
        if round(self.now_s / TICK_S) % 50 == 0 and self.lease:
            self.host.lease(self.now_s, 0.5, True, odometry=True)
        self.host.receive_bytes(self.lines[1].carry(data, self.now_s), self.now_s)
        self.host.tick(self.now_s)
        self.waiting = self.lines[0].carry(self.host.bytes_to_send(self.now_s), self.now_s)
        while self.host.next_event() is not None:
            pass

    def until(self, what: str, seconds: float) -> None:
        """Run until an expression over the bench holds."""
        end_s = self.now_s + seconds
        checks = {
            "up": lambda: self.host.state.is_up,
            "running": lambda: (
                self.host.status is not None and self.host.status.state is RobotState.RUN
            ),
            "done": lambda: self.host.upload_state is not None and self.host.upload_state.done,
            "estop": lambda: self.host.estopped and not self.host.estop_pending,
        }
        while not checks[what]():
            if self.now_s > end_s:
                raise TimeoutError(f"not {what} after {seconds} s: {self.host.status}")
            self.tick()


class RecordedRtt(RttEstimate):
    """Keeps every round trip as well, for the smoothed one is no median."""

    def __init__(self) -> None:
        super().__init__()
        self.taken_s: list[float] = []

    def add(self, rtt_s: float) -> None:
        self.taken_s.append(rtt_s)
        super().add(rtt_s)


def throughput(avr: AvrRobot, count: int, faults: str, seed: int) -> tuple[float, float, int]:
    """Waypoints a second from the first to the last accepted; the median round trip; resends."""
    bench, rtt = Bench(avr, seed, faults), RecordedRtt()
    bench.host.rtt = rtt
    bench.until("up", 10.0)
    # all in one place: the robot executes them as fast as they come
    bench.host.upload(Mission(seed + 1, [Waypoint(0.0, 0.0, 0.3)] * count), bench.now_s)
    upload = bench.host.upload_state
    assert upload is not None
    first_s = 0.0
    end_s = bench.now_s + 60.0
    while not upload.complete and bench.now_s < end_s:
        bench.tick()
        if not first_s and upload.executed >= 32:
            first_s, first = bench.now_s, upload.accepted
        status = bench.host.status
        if status is not None and status.state in (RobotState.HOLD, RobotState.IDLE):
            bench.host.start(bench.now_s)
    rate = (upload.accepted - first) / (bench.now_s - first_s)
    bench.until("done", 20.0)
    return rate, statistics.median(rtt.taken_s), bench.host.counters.retransmits


def emergency_stops(avr: AvrRobot, runs: int) -> list[float]:
    """From the call to the motors without power, with a full queue and window, in seconds."""
    delays = []
    for seed in range(runs):
        bench = Bench(avr, seed)
        bench.until("up", 10.0)
        line = [Waypoint(0.001 * i, 0.0, 0.45) for i in range(3000)]
        bench.host.upload(Mission(seed + 1, line), bench.now_s)
        bench.until("running", 10.0)
        for _ in range(1100 + seed * 7 % 97):
            bench.tick()
        assert bench.motors.powered
        asked_s = bench.motors.now_s
        bench.host.estop()
        # the order meets the line as it is: a frame may be half sent
        bench.waiting += bench.host.bytes_to_send(bench.now_s)
        bench.until("estop", 2.0)
        assert not bench.motors.powered
        delays.append(bench.motors.off_s - asked_s)
    return delays


def parser_speed() -> float:
    """Bytes a second that the Python parser takes from full frames."""
    frame = encode_frame(Frame(MessageType.WAYPOINTS, 1, bytes(range(106))), Sender.ROBOT)
    stream = frame * 2000
    took = []
    for _ in range(5):
        parser = FrameParser(Sender.ROBOT)
        began_s = time.perf_counter()
        frames = parser.feed(stream)
        took.append(time.perf_counter() - began_s)
        assert len(frames) == 2000
    return len(stream) / statistics.median(took)


def main() -> int:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--quick", action="store_true")
    quick = arguments.parse_args().quick
    missing = missing_tools()
    if missing is not None:
        print(f"needs {missing}: see tests/support/avr_robot.py", file=sys.stderr)
        return 2
    count, runs = (600, 10) if quick else (3000, 100)
    with AvrRobot() as avr:
        clean, rtt_s, _ = throughput(avr, count, "", 1)
        lossy, _, resent = throughput(avr, count, "drop=0.001", 2)
        delays = sorted(emergency_stops(avr, runs))
        flash, ram = avr.flash_bytes, avr.ram_bytes
    p99_s = delays[min(len(delays) - 1, math.ceil(0.99 * len(delays)) - 1)]
    speed = parser_speed()
    rows = [
        ("waypoints a second at 115200", ">= 450", f"{clean:.0f}"),
        ("the same, 0.1 % of bytes lost both ways", ">= 380", f"{lossy:.0f} ({resent} resent)"),
        (
            f"acknowledgement round trip of frames of {BATCH} waypoints, median",
            "<= 12 ms",
            f"{rtt_s * 1e3:.1f} ms",
        ),
        ("e-stop to motors off, median", "", f"{statistics.median(delays) * 1e3:.1f} ms"),
        (f"e-stop to motors off, p99 of {runs}", "<= 15 ms", f"{p99_s * 1e3:.1f} ms"),
        ("parser against the line's rate", ">= 50 x", f"{speed / LINE_BYTES_S:.0f} x"),
        ("flash of the ATmega328P build", "<= 8 KiB", f"{flash} B"),
        ("RAM of it, without the stack", "<= 1.5 KiB", f"{ram} B"),
    ]
    text = [
        "# Figures of the serial link",
        "",
        f"The AVR binary on an emulated ATmega328P at 115200 baud, {count} waypoints a run.",
        "`python -m benchmarks.link` makes this table again.",
        "",
        "| figure | wanted | measured |",
        "|---|---|---|",
        *[f"| {name} | {wanted} | {got} |" for name, wanted, got in rows],
    ]
    print("\n".join(text))
    if not quick:
        RESULT.write_text("\n".join(text) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
