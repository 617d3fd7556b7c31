"""What the page of eight robots costs: bytes and messages a second to a browser, and processor.

    python -m benchmarks.fleet.page [--config configs/crossing.yaml] [--seconds 15] [--rounds 3]

The run is that of `clearway run CONFIG --once` in this process: simulated camera, a pseudo-terminal
and a link's thread for each robot, all in real time. The viewer is a page without a screen in a
process of its own, which acknowledges every picture at once. It is counted while the robots drive,
from the first that does. Rounds are with nobody looking, with the picture off, and with it on, in
turns; printed are the medians. The page's share is the processor time of its thread and of its
workers, that of the run is of all its threads. Writes benchmarks/results/fleet_page.md.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import multiprocessing
import re
import statistics
import tempfile
import threading
import time
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path

from websockets.asyncio.client import ClientConnection, connect

from navigation.config import Config, load_config
from navigation.run.run_report import RunReport
from navigation.run.runner import Runner
from tests.support.runs.packed import unpack

CROSSING = Path(__file__).parents[2] / "configs" / "crossing.yaml"
RESULT = Path(__file__).parents[1] / "results" / "fleet_page.md"
NOBODY, NO_PICTURE, PICTURE = "nobody", "picture off", "picture on"
KINDS = (NOBODY, NO_PICTURE, PICTURE)
PATIENCE_S = 600.0
"""Until robots drive: kernels may have to be compiled."""


@dataclass(slots=True)
class Figures:
    """What was measured of one kind, in all rounds."""

    page: list[float] = field(default_factory=list)
    """Shares of one processor."""
    run: list[float] = field(default_factory=list)
    p50_ms: list[float] = field(default_factory=list)
    p99_ms: list[float] = field(default_factory=list)
    messages_s: defaultdict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    bytes_s: defaultdict[str, list[float]] = field(default_factory=lambda: defaultdict(list))


async def _count(line: ClientConnection, messages: Counter[str], sizes: Counter[str]) -> None:
    """Count what comes by its type; a picture is acknowledged."""
    async for data in line:
        head = unpack(data)[0] if isinstance(data, bytes) else json.loads(data)
        messages[head["type"]] += 1
        sizes[head["type"]] += len(data if isinstance(data, bytes) else data.encode())
        if head["type"] == "picture":
            await line.send(json.dumps({"type": "ack", "number": head["number"]}))


def view(address: str, picture: bool, pipe: Connection) -> None:
    """A viewer in this process; each time it is asked it sends what came so far."""

    async def look() -> None:
        messages: Counter[str] = Counter()
        sizes: Counter[str] = Counter()
        async with connect(address, subprotocols=["clearway.1"], max_size=None) as line:  # type: ignore[list-item]
            await line.send(json.dumps({"type": "watch", "on": picture}))
            counting = asyncio.ensure_future(_count(line, messages, sizes))
            while await asyncio.to_thread(pipe.recv):
                pipe.send((dict(messages), dict(sizes)))
            counting.cancel()

    asyncio.run(look())


class Drive:
    """One run in a thread of its own, which says where its page is and when a robot drives."""

    def __init__(self, config: Config, folder: Path) -> None:
        recording = config.recording.model_copy(update={"runs_dir": folder, "journal": None})
        page = config.dashboard.model_copy(update={"port": 0, "enabled": True})
        changed = config.model_copy(update={"recording": recording, "dashboard": page})
        self.address = ""
        self.serves, self.drives = threading.Event(), threading.Event()
        self.report: RunReport | None = None
        self.runner = Runner(changed, once=True, say=self._hear, socket=folder / "c.sock")
        self._thread = threading.Thread(target=self._run, name="control loop")

    def _hear(self, line: str) -> None:
        found = re.search(r"dashboard at http://([^/]+)/", line)
        if found:
            self.address = f"ws://{found[1]}/live"
            self.serves.set()
        if re.match(r" *[\d.]+ s  \S+ +driving ", line):
            self.drives.set()

    def _run(self) -> None:
        try:
            self.report = self.runner.run().report
        finally:
            self.serves.set()  # whoever waits need not wait any longer
            self.drives.set()

    def __enter__(self) -> Drive:
        self._thread.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self.runner.interrupt.set()
        self._thread.join()


def page_s() -> float:
    """Processor time of the page's thread and its workers so far."""
    ours = (one for one in threading.enumerate() if one.name.startswith("dashboard"))
    clocks = (time.pthread_getcpuclockid(one.ident) for one in ours if one.ident is not None)
    return sum(time.clock_gettime(clock) for clock in clocks)


def measure(config: Config, kind: str, seconds: float, figures: Figures) -> None:
    """One run with this kind of viewer."""
    with tempfile.TemporaryDirectory() as folder, Drive(config, Path(folder)) as drive:
        if not drive.serves.wait(PATIENCE_S) or not drive.address:
            raise RuntimeError("the run serves no page")
        ours, theirs = multiprocessing.Pipe()
        arguments = (drive.address, kind == PICTURE, theirs)
        viewer = multiprocessing.get_context("spawn").Process(target=view, args=arguments)
        if kind != NOBODY:
            viewer.start()
        if not drive.drives.wait(PATIENCE_S) or drive.report is not None:
            why = "" if drive.report is None else f": {drive.report.reason}"
            if kind != NOBODY:
                viewer.kill()
            raise RuntimeError(f"no robot has driven, is the machine busy?{why}")
        before = asked(ours) if kind != NOBODY else ({}, {})
        began_s, page, process = time.monotonic(), page_s(), time.process_time()
        threading.Event().wait(seconds)
        passed_s = time.monotonic() - began_s
        figures.page.append((page_s() - page) / passed_s)
        figures.run.append((time.process_time() - process) / passed_s)
        if kind != NOBODY:
            after = asked(ours)
            ours.send(False)
            viewer.join()
            for name, count in after[0].items():
                figures.messages_s[name].append((count - before[0].get(name, 0)) / passed_s)
                figures.bytes_s[name].append((after[1][name] - before[1].get(name, 0)) / passed_s)
    assert drive.report is not None
    wires = [one.latency_ms.capture_to_wire for one in drive.report.robots.values()]
    figures.p50_ms.append(statistics.median(one.p50 for one in wires if one.p50 is not None))
    figures.p99_ms.append(max(one.p99 for one in wires if one.p99 is not None))


def asked(pipe: Connection) -> tuple[dict[str, int], dict[str, int]]:
    """What a viewer has counted so far."""
    pipe.send(True)
    counted: tuple[dict[str, int], dict[str, int]] = pipe.recv()
    return counted


def table(found: dict[str, Figures], robots: int, seconds: float, rounds: int) -> str:
    """The results as Markdown."""
    middle = statistics.median
    lines = [
        "# What the page of several robots costs",
        "",
        f"`python -m benchmarks.fleet.page`: {robots} robots in real time, {rounds} rounds of"
        f" {seconds:g} s each way, medians.",
        "",
        "| looking | page's share of a processor | the whole run's | capture to wire p50 | p99 |"
        " messages/s | kB/s |",
        "|---|---|---|---|---|---|---|",
    ]
    for kind, one in found.items():
        messages = sum(middle(each) for each in one.messages_s.values())
        size = sum(middle(each) for each in one.bytes_s.values()) / 1e3
        told = f"{messages:.1f} | {size:.1f}" if kind != NOBODY else "- | -"
        lines.append(
            f"| {kind} | {100 * middle(one.page):.1f} % | {100 * middle(one.run):.0f} %"
            f" | {middle(one.p50_ms):.1f} ms | {middle(one.p99_ms):.1f} ms | {told} |"
        )
    lines += ["", "| message | a second | bytes each | kB/s |", "|---|---|---|---|"]
    one = found[PICTURE]
    for name in sorted(one.bytes_s, key=lambda name: -middle(one.bytes_s[name])):
        rate, size = middle(one.messages_s[name]), middle(one.bytes_s[name])
        if rate > 0.0:
            lines.append(f"| {name} | {rate:.1f} | {size / rate:.0f} | {size / 1e3:.1f} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Print the table, and write it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", type=Path, default=CROSSING)
    parser.add_argument("--seconds", type=float, default=15.0)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    config = load_config(given.config, {})
    found = {kind: Figures() for kind in KINDS}
    for number in range(given.rounds):
        for kind in KINDS if number % 2 == 0 else KINDS[::-1]:
            measure(config, kind, given.seconds, found[kind])
            print(f"round {number + 1}, {kind}: {found[kind].page[-1]:.3f}", flush=True)
    text = table(found, len(config.robots), given.seconds, given.rounds)
    RESULT.write_text(text)
    print(text)


if __name__ == "__main__":
    main()
