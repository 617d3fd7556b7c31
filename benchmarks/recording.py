"""What recording costs, what a kill loses, and how fast and how exactly a recording replays.

    python -m benchmarks.recording [--kills N] [--runs N]

Pictures are the simulated camera's, 1280x960, grey. The peer is mcap's own Python writer, given
the same pictures already encoded. Processor times are of the whole process, so that the
recorder's thread counts. Writes benchmarks/results/recording.md.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from mcap.writer import CompressionType, Writer

from navigation.recording.compare import ComparisonTolerances
from navigation.recording.reader import read_recording
from navigation.run.replay import replay
from tests.support.runs.recordings import RecordedBench, recording_config

ROOT = Path(__file__).parents[1]
RESULT = Path(__file__).parent / "results" / "recording.md"
PICTURES = 60
KILL_AFTER_S = 3.0
KILLED = """
import sys, time
from pathlib import Path
from tests.support.runs.recordings import RecordedBench, recording_config
bench = RecordedBench(recording_config(), Path(sys.argv[1]))
offset_s = bench.now_s - time.monotonic()
bench.recorder._clock = lambda: time.monotonic() + offset_s
with bench.recorder:
    while True:
        bench.frame()
        print(repr(bench.now_s), flush=True)
        time.sleep(max(0.0, bench.now_s - offset_s - time.monotonic()))  # at the camera's pace
"""
MISSION = """mission:
  stations:
    - {x_m: 0.20, y_m: 0.75}
    - {x_m: 0.20, y_m: 1.40, heading_deg: 90}
"""


def recorded(folder: Path, form: str) -> tuple[float, list[float], Path]:
    """Processor seconds a frame for recording alone, the waits of `saw`, and the file."""
    bench = RecordedBench(recording_config(picture_rate_hz=60.0, picture_format=form), folder)
    frames = []
    for _ in range(PICTURES):
        frame = bench.camera.read(1.0)
        assert frame is not None
        frames.append((frame, bench.eye.look(frame)))
    waits = []
    begin_s = time.process_time()
    with bench.recorder:
        for frame, glimpse in frames:
            asked_s = time.perf_counter()
            bench.recorder.saw(frame, glimpse.poses, None)
            waits.append(time.perf_counter() - asked_s)
            while not bench.is_written():
                threading.Event().wait(0.0005)
    (file,) = folder.glob("*.mcap")
    return (time.process_time() - begin_s) / PICTURES, waits, file


def encoded(folder: Path, form: str) -> tuple[float, float, int]:
    """Processor seconds a picture: encoding alone, and with mcap's writer; bytes a picture."""
    bench = RecordedBench(recording_config(), folder)
    frames = [bench.camera.read(1.0) for _ in range(PICTURES)]
    options = [cv2.IMWRITE_JPEG_QUALITY, 92] if form == "jpeg" else [cv2.IMWRITE_PNG_COMPRESSION, 1]
    begin_s = time.process_time()
    data = [
        cv2.imencode(".jpg" if form == "jpeg" else ".png", frame.image, options)[1].tobytes()
        for frame in frames
        if frame is not None
    ]
    alone_s = time.process_time() - begin_s
    begin_s = time.process_time()
    with (folder / "peer.bin").open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start()
        schema = writer.register_schema("image", "", b"")
        channel = writer.register_channel("/camera", "image", schema)
        for number, one in enumerate(data):
            writer.add_message(channel, number, one, number)
        writer.finish()
    peer_s = alone_s + time.process_time() - begin_s
    return alone_s / PICTURES, peer_s / PICTURES, sum(map(len, data)) // PICTURES


def loss_s(folder: Path) -> float:
    """How much of its last time a recording lost that was killed."""
    with subprocess.Popen(
        [sys.executable, "-c", KILLED, str(folder)], stdout=subprocess.PIPE, text=True, cwd=ROOT
    ) as process:
        assert process.stdout is not None
        seen = [float(process.stdout.readline())]
        jitter_s = float(np.random.default_rng().uniform(0.0, 1.0))
        until_s = time.monotonic() + KILL_AFTER_S + jitter_s
        while time.monotonic() < until_s:
            seen.append(float(process.stdout.readline()))
        process.kill()
        seen += [float(line) for line in process.stdout.read().splitlines()]
    (file,) = folder.glob("*.mcap")
    frames = read_recording(file).frames.values()
    return seen[-1] - max(frame.captured_s for frame in frames)


def run_cost_ms(folder: Path, record: bool) -> float:
    """Processor time a frame of a short run in real time, start and end of it included."""
    shutil.copytree(ROOT / "configs", folder, dirs_exist_ok=True)
    text = (folder / "simulation.yaml").read_text()
    text = re.sub(r"^mission:\n(?:  .*\n)+", MISSION, text, flags=re.MULTILINE)
    (folder / "short.yaml").write_text(text)
    arguments = ["run", "short.yaml", "--once", "--quiet", "--no-dashboard"]
    arguments += ["--socket", str(folder / "private" / "socket"), "--report", "report.json"]
    arguments += ["--record", "recorded"] if record else []
    program = [sys.executable, "-c", "from navigation.cli.main import main; main()"]
    before_s = children_s()
    subprocess.run(
        [*program, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
        stdout=subprocess.DEVNULL,
    )
    frames = json.loads((folder / "report.json").read_text())["frames"]["processed"]
    return 1e3 * (children_s() - before_s) / float(frames)


def children_s() -> float:
    """Processor seconds of the processes that this one has waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def in_folder(work: Callable[[Path], object]) -> object:
    """Run something with a folder of its own."""
    with tempfile.TemporaryDirectory() as name:
        return work(Path(name))


def cost_rows() -> list[str]:
    """The cost of a picture, in both formats, beside the peer's."""
    rows = [
        "| format | bytes a picture | encoding alone, ms | recorder, ms | mcap's writer, ms "
        "| recorder / peer |",
        "|---|---|---|---|---|---|",
    ]
    for form in ("jpeg", "png"):
        best: list[tuple[float, float, float, int]] = []
        for _ in range(3):
            with tempfile.TemporaryDirectory() as name:
                ours_s, _, _ = recorded(Path(name) / "ours", form)
                alone_s, peer_s, size = encoded(Path(name), form)
            best.append((ours_s, alone_s, peer_s, size))
        ours_ms, alone_ms, peer_ms = (1e3 * min(one[i] for one in best) for i in range(3))
        rows.append(
            f"| {form} | {best[0][3]} | {alone_ms:.2f} | {ours_ms:.2f} | {peer_ms:.2f} "
            f"| {ours_ms / peer_ms:.2f} |"
        )
    return rows


def wait_row() -> str:
    """How long the control loop waits for the recorder."""
    with tempfile.TemporaryDirectory() as name:
        _, waits, _ = recorded(Path(name) / "ours", "jpeg")
    p50, p99 = np.percentile(np.array(waits) * 1e6, [50.0, 99.0])
    return f"The control loop spends {p50:.0f} us (p50), {p99:.0f} us (p99) on a frame's record."


def replay_rows() -> list[str]:
    """Speed and exactness of a replay."""
    rows = [
        "| format | pictures/s | position, mm | heading, deg | borders, mm | path, mm |",
        "|---|---|---|---|---|---|",
    ]
    for form in ("jpeg", "png"):
        with tempfile.TemporaryDirectory() as name:
            bench = RecordedBench(
                recording_config(picture_rate_hz=60.0, picture_format=form), Path(name)
            )
            with bench.recorder:
                bench.frames(PICTURES)
                bench.plan()
            recording = read_recording(bench.recorder.path)
            begin_s = time.process_time()
            result = replay(recording, ComparisonTolerances())
            took_s = time.process_time() - begin_s
        far = result.largest
        rows.append(
            f"| {form} | {result.pictures / took_s:.0f} | {far.position_m * 1e3:.4f} "
            f"| {np.rad2deg(far.heading_rad):.4f} | {far.scene_m * 1e3:.4f} "
            f"| {far.path_m * 1e3:.4f} |"
        )
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--runs", type=int, default=3)
    arguments = parser.parse_args()
    page = Page()
    page.add("# Recording and replay", "", "Made by `python -m benchmarks.recording`. Processor")
    page.add("time, the least of three; the peer in the same run.", "", *cost_rows(), "")
    page.add(wait_row(), "")
    page.add("Replay, and how far it is from what was recorded:", "", *replay_rows(), "")
    losses = [float(str(in_folder(loss_s))) for _ in range(arguments.kills)]
    page.add(
        f"After kill -9 at {len(losses)} random moments: lost {statistics.median(losses):.2f} s "
        f"(median), {max(losses):.2f} s at most; the limit is 1 s.",
        "",
    )
    found: dict[bool, list[float]] = {False: [], True: []}
    for _ in range(arguments.runs):
        for record in found:
            with tempfile.TemporaryDirectory() as name:
                found[record].append(run_cost_ms(Path(name), record))
    without_ms, with_ms = (min(found[record]) for record in (False, True))
    page.add(
        "A whole run (simulated camera, vision, planner, link; 10 recorded pictures a second)",
        f"takes {with_ms:.1f} ms of processor time a frame with recording and {without_ms:.1f} ms",
        f"without, the least of {arguments.runs}: {with_ms / without_ms:.2f} times as much.",
    )
    RESULT.write_text("\n".join(page.lines) + "\n", encoding="utf-8")


class Page:
    """Lines that are shown as they come."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def add(self, *lines: str) -> None:
        """Keep and show lines."""
        self.lines += lines
        print("\n".join(lines), flush=True)


if __name__ == "__main__":
    main()
