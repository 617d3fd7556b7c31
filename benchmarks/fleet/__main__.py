"""Several robots on a graph, beside Continuous-CBS: how many tasks, how long, how good.

    python -m benchmarks.fleet [--data ../shared/data/fleet] [--agents 10,13,20,40]
        [--output benchmarks/results/fleet.md]

The data are the tasks that Continuous-CBS (Andreychuk et al., AAAI 2021) was published with: two
graphs, ``ccbs_sparse.json`` and ``ccbs_dense.json``, 25 tasks each, of which a run with n robots
takes the first n, and the rows of its best variant with a limit of 30 s. The folder is ``--data``,
else CLEARWAY_FLEET_DATA, else ``../shared/data/fleet`` where that is there.

A task counts as answered where a plan was found or proved not to exist. Each plan is judged once
more by closed-form closest approaches of all pairs. Times are of the wall and of the processor, in
ms, for the whole call with default shortening; "first" is without. The ratio is the sum of
arrivals over that of Continuous-CBS, where it has one.

With CCBS_SOURCE, the folder of its source, Continuous-CBS is compiled with g++ (Boost's headers)
and run on the same tasks right after ours, a limit of 30 s each; without, its published rows stand.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import planner
from planner.fleet.fleet_plan import FleetPlan, NoFleetPlan

LIMIT_S = 30.0
HERE = Path(__file__).parents[2]


def data_folder(given: str | None) -> Path:
    """Where the tasks are; ends the program with a sentence where they are not."""
    folder = Path(given or os.environ.get("CLEARWAY_FLEET_DATA") or HERE / "../shared/data/fleet")
    if not (folder / "ccbs_sparse.json").is_file():
        sys.exit(f"{folder}: no ccbs_sparse.json there: name the folder with --data")
    return folder


def timed(work: Callable[[], Any]) -> tuple[Any, float, float]:
    """What the work returned, and its milliseconds by the wall and of the processor."""
    wall, processor = time.perf_counter(), time.process_time()
    result = work()
    return result, 1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - processor)


def least_gap(plan: FleetPlan, radius: float) -> float:
    """What is left between the two robots that come nearest."""
    from planner.fleet.motions.track_kernels import least_distance

    tracks = plan.tracks
    return min(
        least_distance(tracks[i], tracks[j])[0] - 2.0 * radius
        for i in range(len(tracks))
        for j in range(i)
    )


def flowtime_of_ccbs(
    program: Path | None, data: dict[str, Any], task: int, agents: int
) -> float | None:
    """The sum of arrivals of Continuous-CBS: run now, or as published; None where it has none."""
    if program is not None:
        return run_ccbs(program, data, data["tasks"][task][:agents])
    rows = [r for r in data["published"][task] if r["agents"] == agents]
    return float(rows[0]["flowtime"]) if rows and rows[0]["runtime_s"] < LIMIT_S else None


def build_ccbs(source: str | None, folder: Path) -> Path | None:
    """The program of Continuous-CBS from its source; None without one, or where g++ fails."""
    if source is None:
        return None
    program = folder / "ccbs"
    files = [str(f) for f in Path(source).rglob("*.cpp")]
    built = subprocess.run(
        ["g++", "-O3", "-std=c++11", f"-I{source}", *files, "-o", str(program)],
        check=False, capture_output=True, text=True,
    )  # fmt: skip
    if built.returncode:
        print(f"Continuous-CBS does not compile: {built.stderr[:300]}", file=sys.stderr)
        return None
    return program


def run_ccbs(program: Path, data: dict[str, Any], task: list[list[int]]) -> float | None:
    """Run it on one task; its sum of arrivals, None where it has no plan in time."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        graph = ElementTree.Element("graphml")
        body = ElementTree.SubElement(graph, "graph", id="G", edgedefault="directed")
        for i, (x, y) in enumerate(data["nodes"]):
            node = ElementTree.SubElement(body, "node", id=f"n{i}")
            ElementTree.SubElement(node, "data", key="key0").text = f"{x},{y}"
        for i, (a, b) in enumerate(data["edges"]):
            edge = ElementTree.SubElement(body, "edge", id=f"e{i}", source=f"n{a}", target=f"n{b}")
            ElementTree.SubElement(edge, "data", key="key1").text = "1"
        ElementTree.ElementTree(graph).write(folder / "map.xml")
        root = ElementTree.Element("root")
        for a, b in task:
            ElementTree.SubElement(root, "agent", start_id=str(a), goal_id=str(b))
        ElementTree.ElementTree(root).write(folder / "task.xml")
        config = ElementTree.Element("root")
        algorithm = ElementTree.SubElement(config, "algorithm")
        for key, value in (
            ("use_cardinal", "true"), ("use_disjoint_splitting", "true"), ("hlh_type", "2"),
            ("agent_size", str(data["radius"])), ("timelimit", f"{LIMIT_S:g}"),
            ("precision", "0.0000001"),
        ):  # fmt: skip
            ElementTree.SubElement(algorithm, key).text = value
        ElementTree.ElementTree(config).write(folder / "config.xml")
        files = [str(folder / f"{part}.xml") for part in ("map", "task", "config")]
        try:
            done = subprocess.run(
                [str(program), *files], check=False, capture_output=True, text=True,
                timeout=2.0 * LIMIT_S, cwd=folder,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return None
        found = re.search(r"[Ff]lowtime:?\s*([\d.]+)", done.stdout)
        solved = re.search(r"Sou?lution found: true", done.stdout)
        return float(found[1]) if found and solved else None


def row(data: dict[str, Any], name: str, agents: int, program: Path | None) -> str:
    """One line of the table: a graph with so many robots."""
    walls, processors, firsts, ratios = [], [], [], []
    plans = proved = by_ccbs = 0
    gap = float("inf")
    for number, whole in enumerate(data["tasks"]):
        task = whole[:agents]
        request = (
            data["nodes"], data["edges"], data["radius"], [a for a, _ in task],
            [b for _, b in task], LIMIT_S,
        )  # fmt: skip
        plan, wall, processor = timed(lambda r=request: planner.plan_on_graph(*r))
        _, _, first = timed(lambda r=request: planner.plan_on_graph(*r, improve=0))
        walls.append(wall)
        processors.append(processor)
        firsts.append(first)
        reference = flowtime_of_ccbs(program, data, number, agents)
        by_ccbs += reference is not None
        if isinstance(plan, NoFleetPlan):
            proved += plan.proved
            print(f"{name}, {agents} robots, task {number}: {plan.reason}", file=sys.stderr)
            continue
        plans += 1
        gap = min(gap, least_gap(plan, data["radius"]))
        if reference is not None:
            ratios.append(plan.flowtime_s / reference)
    quality = f"{statistics.fmean(ratios):.4f} / {max(ratios):.4f}" if ratios else "-"
    return (
        f"| {name} | {agents} | {plans} + {proved} | {by_ccbs} |"
        f" {statistics.median(walls):.0f} / {max(walls):.0f} |"
        f" {statistics.median(processors):.0f} / {max(processors):.0f} |"
        f" {statistics.median(firsts):.0f} / {max(firsts):.0f} | {quality} | {gap:.1e} |"
    )


HEAD = [
    "| graph | robots | planned + proved impossible, of 25 | by Continuous-CBS in 30 s |"
    " wall ms, median / worst | processor ms, median / worst |"
    " first plan, processor ms, median / worst |"
    " arrivals over Continuous-CBS, mean / worst | least gap |",
    "|---|---|---|---|---|---|---|---|---|",
]


def main() -> None:
    """Print the table, and write it where asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data")
    parser.add_argument("--agents", default="10,13,20,40")
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    folder = data_folder(options.data)
    lines = list(HEAD)
    with tempfile.TemporaryDirectory() as built:
        program = build_ccbs(os.environ.get("CCBS_SOURCE"), Path(built))
        for name in ("sparse", "dense"):
            data = json.loads((folder / f"ccbs_{name}.json").read_text())
            # compiles the kernels, where they are not kept
            planner.plan_on_graph(data["nodes"], data["edges"], data["radius"], [0], [0])
            lines += [row(data, name, int(n), program) for n in options.agents.split(",")]
    text = "\n".join(lines) + "\n"
    print(text)
    if options.output is not None:
        how = "run beside ours" if program is not None else "as published, limit 30 s"
        options.output.write_text(
            "# Several robots on a graph\n\n"
            "`python -m benchmarks.fleet --output benchmarks/results/fleet.md`;"
            f" Continuous-CBS {how}.\n\n{text}"
        )


if __name__ == "__main__":
    main()
