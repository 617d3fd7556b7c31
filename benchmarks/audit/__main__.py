"""Count and time: see :mod:`benchmarks.audit`.

python -m benchmarks.audit [--graphs 500] [--seed 1] [--output benchmarks/results/audit.md]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Final

import numpy as np

import planner
from benchmarks.audit.distances import Verdict
from benchmarks.audit.frames import LOST, NEAR_M, FrameCounts
from benchmarks.audit.judge import Judge
from benchmarks.audit.planted import RADIUS_M, Case, fill, plant, random_map
from benchmarks.audit.repairs import RepairCounts
from benchmarks.audit.stretches import StretchCounts
from benchmarks.audit.turns import TURNING_M
from planner import RouteEdge, RouteGraph, RouteNode

LARGE_CELLS: Final = 4000
LARGE_EDGES: Final = 10_000
LARGE_BAR_S: Final = 5.0


def main() -> None:
    """Print the table, and write it."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.audit", description=__doc__)
    parser.add_argument("--graphs", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/audit.md"))
    asked = parser.parse_args()
    lines = [*judged(asked.graphs, asked.seed), "", *large(asked.seed)]
    text = "# The audit of route graphs\n\n" + "\n".join(lines) + "\n"
    print(text)
    asked.output.write_text(text)


def judged(graphs: int, seed: int) -> list[str]:
    """Audit random graphs with planted faults; a table of what was found, missed and invented."""
    wanted: Counter[str] = Counter()
    found: Counter[str] = Counter()
    false: Counter[str] = Counter()
    planted = sound = 0
    frames, repairs, stretches = FrameCounts(), RepairCounts(), StretchCounts()
    for number in range(graphs):
        rng = np.random.default_rng((seed, number))
        judge = Judge(case := random_map(rng))
        fill(case, rng, judge.is_sound)
        sound += not _reported(case, turning=False)
        frames.add(number, case, judge, rng)
        plant(case, rng)
        stretches.add(case, judge, f"graph {number}")
        repairs.add(case, judge, f"graph {number}")
        verdict = judge.judge(case)
        reported = _reported(case)
        planted += len(case.planted)
        _count(verdict, reported, wanted, found, false, f"graph {number}")
    kinds = sorted(wanted.keys() | false.keys())
    total, hit = sum(wanted.values()), sum(found.values())
    return [
        f"{graphs} random graphs on random maps, sound at first ({sound} without a finding), then"
        f" with {planted} faults planted in them besides edges and nodes anywhere; the judge is"
        " independent (`benchmarks/audit/judge.py`). `python -m benchmarks.audit` makes this"
        " again.",
        "",
        f"**{hit} of {total} found, {sum(false.values())} false.**",
        "",
        "| kind | sure to be there | found | false |",
        "|---|---|---|---|",
        *(f"| `{kind}` | {wanted[kind]} | {found[kind]} | {false[kind]} |" for kind in kinds),
        "",
        stretches.sentence(),
        "",
        "## Other frames",
        "",
        f"Each graph, before faults are planted, in another frame. *Lost*: less than {LOST:.0%} of"
        " its length is free by the judge; *missed*: lost, and no transform offered; *free*: at"
        " least 90 % of it is free by the judge where it was put; *put back*: its nodes are within"
        f" {NEAR_M:g} m of where they were, on average. Rooms with a symmetry have several answers:"
        " then the audit is not sure.",
        "",
        *frames.table(),
        "",
        "## Repairs",
        "",
        "Each graph with its planted faults, repaired. Edges are judged by the distance transform;"
        " a path is looked for by flooding cells that are surely free.",
        "",
        *repairs.table(),
    ]


def _reported(case: Case, *, turning: bool = True) -> set[tuple[str, str]]:
    audit = planner.audit(
        case.graph,
        case.scene,
        RADIUS_M,
        keepout=case.keepout,
        speed=case.speed,
        turning_radius=TURNING_M if turning else None,
    )
    return {(one.kind, one.name) for one in audit.findings}


def _count(
    verdict: Verdict,
    reported: set[tuple[str, str]],
    wanted: Counter[str],
    found: Counter[str],
    false: Counter[str],
    where: str,
) -> None:
    for kind, name in verdict.must:
        wanted[kind] += 1
        found[kind] += (kind, name) in reported
        if (kind, name) not in reported:
            print(f"missed: {where}: {kind} {name}")
    for kind, name in reported - verdict.must - verdict.may:
        false[kind] += 1
        print(f"false: {where}: {kind} {name}")


def large(seed: int) -> list[str]:
    """Time the audit of 10,000 edges on a map of 4,000 x 4,000 cells."""
    rng = np.random.default_rng(seed)
    cells = np.full((LARGE_CELLS, LARGE_CELLS), 254, np.uint8)
    for _ in range(4000):
        r, c = rng.integers(0, LARGE_CELLS, 2)
        h, w = rng.integers(4, 60, 2)
        cells[r : r + h, c : c + w] = 0
    side_m = 0.05 * LARGE_CELLS
    places = rng.uniform(0.0, side_m, (LARGE_EDGES // 4, 2))
    nodes = tuple(RouteNode(k, *place) for k, place in enumerate(places.tolist()))
    edges = []
    for k, place in enumerate(places):
        near = np.argsort(np.hypot(*(places - place).T))[1:5]
        edges += [RouteEdge(len(nodes) + 4 * k + j, k, int(n)) for j, n in enumerate(near)]
    graph = RouteGraph(nodes, tuple(edges), "nav2")
    with tempfile.TemporaryDirectory() as folder:
        place_of_map = Path(folder) / "map.yaml"
        (Path(folder) / "map.pgm").write_bytes(b"P5\n4000 4000\n255\n" + cells.tobytes())
        place_of_map.write_text("image: map.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\n")
        planner.audit(graph, planner.load_scene(place_of_map), 0.2)  # kernels are loaded
        # one thread; on a machine that does other work its wall time says little
        begin_s = time.process_time()
        scene = planner.load_scene(place_of_map)
        read_s = time.process_time()
        audit = planner.audit(graph, scene, 0.2)
        end_s = time.process_time()
    held = "held" if end_s - begin_s <= LARGE_BAR_S else "not held"
    return [
        f"{len(audit.edges)} edges on {LARGE_CELLS} x {LARGE_CELLS} cells with"
        f" {len(scene.objects)} obstacles: the map {read_s - begin_s:.2f} s, the audit"
        f" {end_s - read_s:.2f} s, together {end_s - begin_s:.2f} s of one processor (bar"
        f" {LARGE_BAR_S:g} s: {held}); {len(audit.findings)} findings.",
    ]


if __name__ == "__main__":
    main()
