"""What looking costs: capture to wire with nobody, with viewers of several kinds, and savers.

    python -m benchmarks.dashboard [--seconds 10] [--rounds 3]

One running program with a simulated camera (1280x960, 30 pictures a second) and robot; the
viewers are pages without a screen in a process of their own, which acknowledge every picture at
once: of the picture from above, of the camera's own picture and the clearances, or none but a
recording that they save again and again. The kinds take turns, so that whatever else the
machine does meets all of them. Writes benchmarks/results/dashboard.md.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import multiprocessing
import resource
import statistics
import tempfile
import threading
import time
import urllib.request
from collections import defaultdict
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from websockets.asyncio.client import connect

from navigation.config import Config
from tests.browser.programs.live import Live, live_config
from tests.support.runs.packed import unpack

RESULT = Path(__file__).parent / "results" / "dashboard.md"
SAVING = "saving a recording"
LAYERS = "camera and clearance"
KINDS = ((0, "nothing"), (1, "picture"), (20, "picture"), (5, LAYERS), (4, SAVING))
RUN, TAPE = "2026-01-01_00-00-00", "clearway_2026-01-01_00-00-01_001.mcap"
TAPE_BYTES = 20_000_000
PIECE_BYTES = 524_288
SETTLE_S = 1.0


@dataclass(slots=True)
class Figures:
    """What was measured with one number of viewers, over all rounds."""

    wire_ms: list[float] = field(default_factory=list)
    slowest_ms: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)
    cycles_s: list[float] = field(default_factory=list)
    pictures_s: list[float] = field(default_factory=list)
    picture_age_ms: list[float] = field(default_factory=list)
    pieces: list[int] = field(default_factory=list)


def save(address: str, until_s: float) -> int:
    """Fetch a recording piece by piece, again and again; how many pieces came."""
    url = address.replace("ws://", "http://").removesuffix("live") + f"api/runs/{RUN}/{TAPE}"
    count = 0
    while time.monotonic() < until_s:
        first = count * PIECE_BYTES % (TAPE_BYTES - PIECE_BYTES)
        piece = {"Range": f"bytes={first}-{first + PIECE_BYTES - 1}"}
        with urllib.request.urlopen(urllib.request.Request(url, headers=piece)) as answer:
            assert len(answer.read()) == PIECE_BYTES
        count += 1
    return count


async def look(address: str, kind: str, until_s: float, ages_ms: list[float]) -> int:
    """One viewer; how many pictures or pieces it got."""
    if kind == SAVING:
        return await asyncio.to_thread(save, address, until_s)
    count, layers = 0, kind == LAYERS
    async with connect(address, subprotocols=["clearway.1"]) as line:  # type: ignore[list-item]
        await line.send(json.dumps({"type": "watch", "on": True, "camera": layers, "heat": layers}))
        while (left_s := until_s - time.monotonic()) > 0.0:
            try:
                data = await asyncio.wait_for(line.recv(), left_s)
            except TimeoutError:
                break
            if isinstance(data, bytes) and (head := unpack(data)[0])["type"] in (
                "picture",
                "camera",
            ):
                count += 1
                ages_ms.append(head["age_ms"])
                await line.send(json.dumps({"type": "ack", "number": head["number"]}))
    return count


def view(address: str, viewers: int, kind: str, seconds: float, pipe: Connection) -> None:
    """So many viewers in this process; sends the pictures of each and their ages."""

    async def everybody() -> None:
        until_s = time.monotonic() + seconds
        ages_ms: list[float] = []
        counts = await asyncio.gather(
            *(look(address, kind, until_s, ages_ms) for _ in range(viewers))
        )
        pipe.send((counts, ages_ms))

    asyncio.run(everybody())


def measure(live: Live, viewers: int, kind: str, seconds: float, figures: Figures) -> None:
    """One stretch with so many viewers."""
    address = live.url.replace("http", "ws") + "live"
    ours, theirs = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(
        target=view, args=(address, viewers, kind, SETTLE_S + seconds + 2.0, theirs)
    )
    process.start()
    hub = live.hub
    while len(hub.viewers) < viewers and kind != SAVING:
        threading.Event().wait(0.05)
    threading.Event().wait(SETTLE_S)
    times = live.daemon.robot.link.capture_to_wire_s
    times.clear()
    processed, pictures = live.daemon.view.processed, hub.pictures_sent
    began_s, used_s = time.monotonic(), processor_s()
    threading.Event().wait(seconds)
    passed_s = time.monotonic() - began_s
    wire_ms = np.array(times) * 1e3
    figures.wire_ms.append(float(np.median(wire_ms)))
    figures.slowest_ms.append(float(np.percentile(wire_ms, 99)))
    figures.processor.append((processor_s() - used_s) / passed_s)
    figures.cycles_s.append((live.daemon.view.processed - processed) / passed_s)
    if viewers:
        figures.pictures_s.append((hub.pictures_sent - pictures) / passed_s / viewers)
        counts, ages_ms = ours.recv()
        figures.picture_age_ms.append(statistics.median(ages_ms or [0.0]))
        figures.pieces.append(sum(counts) if kind == SAVING else 0)
    process.join()


def processor_s() -> float:
    """Processor time of this process: the program and the simulated world, not the viewers."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def table(found: dict[tuple[int, str], Figures], seconds: float, rounds: int) -> str:
    """The results as Markdown."""
    lines = [
        "# What looking costs",
        "",
        "The shipped simulation at 1280x960, 30 pictures a second;",
        f"{rounds} rounds of {seconds:g} s each, taking turns, and of each the least disturbed,",
        "since other work on the machine only adds. Ratios are against nobody looking. The",
        "processor's share has the simulated camera and robot in it.",
        "`python -m benchmarks.dashboard` makes this again.",
        "",
        "| viewers | of | capture to wire p50 | ratio | p99 | ratio "
        "| pictures/s seen by the program | pictures/s a viewer "
        "| age of a picture when sent | processor |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    base = found[KINDS[0]]
    for (viewers, kind), one in found.items():
        p50, p99 = min(one.wire_ms), min(one.slowest_ms)
        times = p50 / min(base.wire_ms), p99 / min(base.slowest_ms)
        looks = viewers and kind != SAVING
        watched = f"{max(one.pictures_s):.1f}" if looks else "-"
        age = f"{min(one.picture_age_ms):.0f} ms" if looks else "-"
        lines.append(
            f"| {viewers} | {kind} | {p50:.1f} ms | {times[0]:.2f} | {p99:.1f} ms | {times[1]:.2f} "
            f"| {max(one.cycles_s):.1f} | {watched} | {age} "
            f"| {100 * min(one.processor):.0f} % |"
        )
    return "\n".join(lines) + "\n"


def config_of(folder: Path) -> Config:
    """The shipped simulation with an earlier run that has a recording."""
    (folder / RUN).mkdir()
    (folder / TAPE).write_bytes(bytes(TAPE_BYTES))
    config = live_config(rate_hz=30)
    kept = config.recording.model_copy(update={"runs_dir": folder, "folder": folder})
    return config.model_copy(update={"recording": kept})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--rounds", type=int, default=3)
    asked = parser.parse_args()
    found: dict[tuple[int, str], Figures] = defaultdict(Figures)
    with tempfile.TemporaryDirectory() as folder, Live(config_of(Path(folder))) as live:
        for number in range(asked.rounds):
            for kind in KINDS if number % 2 == 0 else KINDS[::-1]:
                measure(live, *kind, asked.seconds, found[kind])
                print(f"round {number + 1}, {kind}: {found[kind]}", flush=True)
    text = table({kind: found[kind] for kind in KINDS}, asked.seconds, asked.rounds)
    RESULT.write_text(text)
    print(text)


if __name__ == "__main__":
    main()
