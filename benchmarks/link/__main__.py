"""The serial link's figures on the real AVR binary, emulated at its true baud rate.

    python -m benchmarks.link [--quick]

The firmware runs on an emulated ATmega328P (simavr) in lockstep with the host's end in virtual
time, so the figures depend on no machine. Writes benchmarks/results/link.md. Needs what
tests/support/robots/avr_robot.py names. Parser speed is real time on this machine.
"""

from __future__ import annotations

import argparse
import math
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.link import mavlink_upload
from firmware_protocol.host.line.send_window import RttEstimate
from firmware_protocol.host.upload import BATCH
from firmware_protocol.wire.framing import FrameParser, Sender, WireFrame, encode_frame, wire_bytes
from firmware_protocol.wire.messages import MessageType, RobotState, Status, Waypoint
from firmware_protocol.wire.mission import Mission
from tests.support.robots.avr_bench import WIRE_BYTE_S, AvrBench
from tests.support.robots.avr_robot import AvrRobot, missing_tools
from tests.support.robots.emulated_processor import EmulatedProcessor

RESULT = Path(__file__).parents[1] / "results" / "link.md"
LINE_BYTES_S = 11_520.0


class Bench(AvrBench):
    """One that waits for the link, for driving, for its end."""

    def connect(self) -> None:
        self.until(lambda: self.host.state.is_up, 10.0)

    def drive(self) -> None:
        self.until(lambda: self.state() is RobotState.RUN, 10.0)

    def holds(self) -> bool:
        return self.state() is RobotState.HOLD

    def stopped(self) -> bool:
        return self.state() is RobotState.ESTOP and not self.host.estop_pending

    def finish(self) -> None:
        upload = self.host.upload_state
        assert upload is not None
        self.until(lambda: upload.done, 20.0)


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
    bench.connect()
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
    bench.finish()
    return rate, statistics.median(rtt.taken_s), bench.host.counters.retransmits


def emergency_stops(avr: AvrRobot, runs: int) -> list[float]:
    """From the call to the motors without power, with a full queue and window, in seconds."""
    delays = []
    for seed in range(runs):
        bench = Bench(avr, seed)
        bench.connect()
        line = [Waypoint(0.001 * i, 0.0, 0.45) for i in range(3000)]
        bench.host.upload(Mission(seed + 1, line), bench.now_s)
        bench.drive()
        for _ in range(1100 + seed * 7 % 97):
            bench.tick()
        assert bench.motors.powered
        asked_s = bench.motors.now_s
        bench.host.estop()
        # the order meets the line as it is: a frame may be half sent
        bench.waiting += bench.host.bytes_to_send(bench.now_s)
        bench.until(bench.stopped, 2.0)
        assert not bench.motors.powered
        delays.append(bench.motors.off_s - asked_s)
    return delays


def dead_man(avr: AvrRobot, runs: int) -> list[float]:
    """From the lease's limit, counted from its last byte, to the report of HOLD, in seconds.

    Below zero: a lease runs from when it was given, less the bound of the robot's clock.
    The report's own time on the wire is taken off; the frame under way before it is not.
    """
    late = []
    for seed in range(runs):
        bench = Bench(avr, seed)
        bench.connect()
        bench.host.upload(Mission(seed + 1, [Waypoint(0.02 * i, 0.0, 0.4) for i in range(40)]), 0.0)
        bench.drive()
        bench.lease_phase = seed  # the control step comes every ten ticks
        bench.run(0.5)
        bench.lease = False
        bench.until(bench.holds, 1.0)
        told_s = bench.now_s - wire_bytes(Status.LAYOUT.size) * WIRE_BYTE_S
        late.append(told_s - bench.leased_s - 0.5)
    return late


def control_cycles(avr: AvrRobot) -> tuple[float, float]:
    """The main loop's rounds with a control step in them, while driving: median and longest, ms."""
    with tempfile.TemporaryDirectory() as folder:
        rounds_file = Path(folder) / "rounds"
        os.environ["AVR_ROUNDS"] = str(rounds_file)
        processor = EmulatedProcessor(avr.command)
        try:
            bench = Bench(processor)
            bench.connect()
            wave = [Waypoint(0.02 * i, 0.1 * math.sin(0.06 * i), 0.4) for i in range(300)]
            bench.host.upload(Mission(1, wave), bench.now_s)
            bench.drive()
            bench.run(5.0)
            processor.run(0.0)
        finally:
            processor.close()
            del os.environ["AVR_ROUNDS"]
        rounds = [[int(n) for n in line.split()] for line in rounds_file.read_text().splitlines()]
    cycles = [tenths / 10.0 for tenths, count in rounds for _ in range(count) if tenths >= 20]
    return statistics.median(cycles), cycles[-1] + 0.1


def peer_rows(count: int, clean: float, lossy: float) -> list[str]:
    """The same waypoints over the same line by pymavlink, beside this link."""
    if mavlink_upload.missing():
        return ["", "pymavlink is not installed: no row of it (`pip install pymavlink`)."]
    peer = [mavlink_upload.upload(count, faults, 2) for faults in ("", "drop=0.001")]
    ratios = [ours / theirs.waypoints_s for ours, theirs in zip((clean, lossy), peer, strict=True)]
    return [
        "",
        f"Beside pymavlink's mission upload, {count} waypoints, at 115200 baud on the same line;",
        "its vehicle answers in no time (`benchmarks/link/mavlink_upload.py`), ours is the AVR:",
        "",
        "| waypoints a second | Clearway | pymavlink | ratio |",
        "|---|---|---|---|",
        f"| clean line | {clean:.0f} | {peer[0].sentence()} | {ratios[0]:.1f} |",
        f"| 0.1 % of bytes lost both ways | {lossy:.0f} | {peer[1].sentence()} | {ratios[1]:.1f} |",
    ]


def parser_speed() -> float:
    """Bytes a second that the Python parser takes from full frames."""
    frame = encode_frame(WireFrame(MessageType.WAYPOINTS, 1, bytes(range(106))), Sender.ROBOT)
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
        print(f"needs {missing}: see tests/support/robots/avr_robot.py", file=sys.stderr)
        return 2
    count, runs = (600, 10) if quick else (3000, 100)
    with AvrRobot() as avr:
        clean, rtt_s, _ = throughput(avr, count, "", 1)
        lossy, _, resent = throughput(avr, count, "drop=0.001", 2)
        delays = sorted(emergency_stops(avr, runs))
        late = dead_man(avr, max(5, runs // 5))
        cycle_ms, longest_ms = control_cycles(avr)
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
        (
            f"dead-man: HOLD told behind the lease's limit, {len(late)} runs",
            "within 10 ms",
            f"{min(late) * 1e3:.1f} to {max(late) * 1e3:.1f} ms",
        ),
        (
            "the robot's main loop with its control step at 0.4 m/s, every 10 ms",
            "<= 5 ms",
            f"{cycle_ms:.1f} ms, at most {longest_ms:.1f}",
        ),
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
        *peer_rows(count, clean, lossy),
    ]
    print("\n".join(text))
    if not quick:
        RESULT.write_text("\n".join(text) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
