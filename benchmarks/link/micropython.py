"""The MicroPython robot under the real MicroPython: faults, a soak, times.

    python -m benchmarks.link.micropython [--seeds 5] [--minutes 10] [--only TEXT]

- The fault matrix in virtual time, every scenario over the seeds, the heap locked in every call.
- A soak: missions over a bad line with a trouble a minute; the heap in use after a collection, at
  the beginning and the end.
- The control step, waypoints a second and the way to an emergency stop, in real time on this
  machine, and for a Pico by PICO, a factor that is stated and not measured.

Needs MicroPython (``.ci/micropython``). Ends with 1 where a scenario fails or the heap grows.
Writes benchmarks/results/micropython.md where nothing was left out.
"""

from __future__ import annotations

import argparse
import struct
import sys
import time
from pathlib import Path

from benchmarks.soak import FAULTS, Soak
from firmware_protocol.robot.connection import Identity
from firmware_protocol.wire.messages import ESTOP_FRAME, RobotState
from tests.support.robots.micropython_interpreter import interpreter
from tests.support.robots.micropython_robot import MicroRobot, Process
from tests.support.wire.fault_scenarios import SCENARIOS, robot_maker
from tests.support.wire.fault_witness import Witness

RESULT = Path(__file__).parents[1] / "results" / "micropython.md"
PICO = 100
"""A Pico takes so many times as long as this machine: a clock of 133 MHz against about 3 GHz, four
to five times the cycles for an instruction of an in-order core that fetches from flash. Assumed,
not measured: no board was at hand."""


def faults(found: str, seeds: int, only: str) -> tuple[int, list[str]]:
    """How many passed, and what failed."""
    passed, failed = 0, []
    for name in SCENARIOS:
        if only not in name:
            continue
        for seed in range(1, seeds + 1):
            process = Process([found])
            token = robot_maker.set(lambda who, drive, on=process: MicroRobot(on, who, drive))  # type: ignore[misc]
            try:
                SCENARIOS[name](seed)
                passed += 1
            except (AssertionError, OSError) as error:
                failed.append(f"{name}, seed {seed}: {error}")
            finally:
                robot_maker.reset(token)
                process.close()
        print(name, file=sys.stderr, flush=True)
    return passed, failed


def measured(process: Process) -> tuple[int, int, int, int]:
    """Bytes of the heap in use, steps since the last call, their total and longest time (us)."""
    values: tuple[int, int, int, int] = struct.unpack("<4I", process.answer(b"M", 0, b""))
    return values


def soak(found: str, minutes: float) -> tuple[list[int], int, float, int]:
    """The heap in use at each mission's end, waypoints executed, a step's mean and longest time."""
    process = Process([found])
    token = robot_maker.set(lambda who, drive: MicroRobot(process, who, drive))  # type: ignore[arg-type,return-value]
    heap, steps, total_us, longest_us = [], 0, 0, 0
    try:
        run = Soak(1)
        while run.witness.loop.now_s < 60.0 * minutes:
            run.mission()
            used, count, took_us, worst_us = measured(process)
            heap.append(used)
            steps, total_us, longest_us = (
                steps + count,
                total_us + took_us,
                max(longest_us, worst_us),
            )
    finally:
        robot_maker.reset(token)
        process.close()
    return heap, run.executed, total_us / max(steps, 1), longest_us


def stop_s(found: str) -> float:
    """From the emergency stop's frame being given to its being obeyed: the median of a hundred."""
    process = Process([found])
    token = robot_maker.set(lambda who, drive: MicroRobot(process, who, drive))  # type: ignore[arg-type,return-value]
    try:
        witness = Witness(1)
        witness.begin_and_drive()
        robot: object = witness.loop.robot
        assert isinstance(robot, MicroRobot)
        assert robot.controller.state is RobotState.RUN
        times = []
        for _ in range(100):
            began_s = time.perf_counter()
            robot.receive_bytes(ESTOP_FRAME, witness.loop.robot_s)
            times.append(time.perf_counter() - began_s)
        assert robot.controller.state is RobotState.ESTOP
    finally:
        robot_maker.reset(token)
        process.close()
    return sorted(times)[50]


def heap_of_a_robot(found: str) -> int:
    """What a robot that has started needs of the heap, with the modules' code."""
    process = Process([found])
    MicroRobot(process, Identity(boot_id=1))
    used, *_ = measured(process)
    process.close()
    return used


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--only", default="", help="scenarios whose name contains this")
    options = parser.parse_args()
    found = interpreter()
    if found is None:
        print("needs MicroPython: .ci/micropython", file=sys.stderr)
        return 2
    passed, failed = faults(found, options.seeds, options.only)
    heap, executed, mean_us, longest_us = soak(found, options.minutes)
    settled = heap[1:] or heap
    grown = settled[-1] - settled[0]
    stopped_s = stop_s(found)
    text = [
        "# The MicroPython robot under the real MicroPython",
        "",
        "32-bit Unix port, heap locked in every call; made by",
        "`python -m benchmarks.link.micropython`. A Pico by a factor that is assumed, not",
        f"measured: {PICO}.",
        "",
        "| what | here | a Pico, scaled |",
        "|---|---|---|",
        f"| fault matrix, {options.seeds} seeds | {passed} of {passed + len(failed)} passed | |",
        f"| soak, minutes of virtual time over `{FAULTS}` | {options.minutes:g} | |",
        f"| waypoints of missions executed whole | {executed} | |",
        "| heap in use: first mission, last, KiB | "
        f"{settled[0] / 1024:.1f}, {settled[-1] / 1024:.1f} | |",
        f"| heap grown, bytes | {grown} | |",
        f"| control step, mean, us | {mean_us:.0f} | {mean_us * PICO:.0f} of 10,000 |",
        f"| control step, longest (this machine's pauses too), us | {longest_us} | |",
        f"| waypoints accepted and executed, at most, a second | {1e6 / max(mean_us, 1.0):.0f} "
        f"| {1e6 / max(mean_us * PICO, 1.0):.0f} |",
        f"| emergency stop, frame to motors off, us | {stopped_s * 1e6:.0f} | "
        f"{stopped_s * 1e6 * PICO:.0f} |",
    ]
    print("\n".join([*text, *failed]))
    if not options.only and options.seeds >= 5 and options.minutes >= 10.0:
        RESULT.write_text("\n".join(text) + "\n", encoding="utf-8")
    return int(bool(failed) or grown > 0)


if __name__ == "__main__":
    sys.exit(main())
