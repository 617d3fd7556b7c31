"""Audit the route graphs that Nav2 ships, and our roadmaps of the same maps by the same measures.

python -m benchmarks.audit.gallery [--repository FOLDER] [--pictures FOLDER] [--output FILE.md]

Nav2's files (Apache 2.0) are read from a Git repository of navigation2 at `COMMIT`, or fetched from
GitHub; none of them is kept. Pictures of every audit go to the folder of --pictures.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
import urllib.request
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final, NamedTuple

import networkx as nx
import numpy as np

import planner
from navigation.cli.pictures.audit_picture import audit_drawing
from navigation.draw.picture import save_drawing
from planner import GraphAudit, GraphCoverage, RouteGraph
from planner.graph_audit.edge_lines import length_of
from planner.roadmap.roadmap_export import straight_graph

COMMIT: Final = "a3a97043ee93d92fe8d70ec56d183933169beb1c"
FROM: Final = "https://raw.githubusercontent.com/ros-navigation/navigation2"
RADIUS_M: Final = 0.22
"""The radius in Nav2's own parameters, ``robot_radius``."""
REACH_M: Final = 2.0
LEAST_BRANCH_M: Final = 1.0
PAIRS: Final = 60


class Shipped(NamedTuple):
    """A graph of Nav2, its map and, if there is one, its keep-out mask."""

    name: str
    graph: str
    map: str
    keepout: str | None


SHIPPED: Final = (
    Shipped("depot", "depot_graph", "depot", "depot_keepout"),
    Shipped("turtlebot3", "turtlebot3_graph", "tb3_sandbox", None),
    Shipped("warehouse", "warehouse_graph", "warehouse", "warehouse_keepout"),
)
COLUMNS: Final = (
    *("graph", "nodes", "edges", "least clearance", "unsafe", "errors", "warnings"),
    *("covered", "farthest", "to a node", "farthest to one", "connected", "detour", "worst"),
)


def main() -> None:
    """Audit all, and write the page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.audit.gallery")
    parser.add_argument("--repository", type=Path, help="a Git repository of navigation2")
    parser.add_argument("--pictures", type=Path, help="a folder for pictures of the audits")
    parser.add_argument("--output", type=Path, default=Path("docs/how_to/audit_gallery.md"))
    asked = parser.parse_args()
    read = _from_web if asked.repository is None else _reader(asked.repository)
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for one in SHIPPED:
            rows += _audited(one, Path(name), read, asked.pictures)
    text = PAGE.format(
        commit=COMMIT[:10],
        radius=RADIUS_M,
        reach=REACH_M,
        branch=LEAST_BRANCH_M,
        pairs=PAIRS,
        head=f"| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|",
        rows="\n".join(rows),
    )
    print(text)
    asked.output.write_text(text, encoding="utf-8")


def _from_web(path: str) -> bytes:
    with urllib.request.urlopen(f"{FROM}/{COMMIT}/{path}", timeout=30.0) as answer:
        return bytes(answer.read())


def _reader(repository: Path) -> Callable[[str], bytes]:
    def read(path: str) -> bytes:
        command = ["git", "-C", str(repository), "show", f"{COMMIT}:{path}"]
        return subprocess.run(command, check=True, capture_output=True).stdout

    return read


def _audited(
    one: Shipped, folder: Path, read: Callable[[str], bytes], pictures: Path | None
) -> list[str]:
    """Rows of the table of one map: Nav2's graph, the same repaired, and our roadmap."""
    names = [f"graphs/{one.graph}.geojson"]
    for picture in (one.map, one.keepout):
        names += [f"maps/{picture}.yaml", f"maps/{picture}.pgm"] if picture else []
    for name in names:
        (folder / Path(name).name).write_bytes(read(f"nav2_bringup/{name}"))
    scene = planner.load_scene(folder / f"{one.map}.yaml")
    zones = planner.load_mask(folder / f"{one.keepout}.yaml") if one.keepout else None
    given = planner.load_graph(folder / f"{one.graph}.geojson")
    objects = [*scene.objects, *(() if zones is None else zones.objects)]
    joined = replace(scene, objects=tuple(replace(o, id=k) for k, o in enumerate(objects)))
    roadmap = planner.build_roadmap(joined, RADIUS_M, least_branch=LEAST_BRANCH_M)
    graphs = {
        f"{one.name}, Nav2's": given,
        f"{one.name}, repaired": planner.repair(given, scene, RADIUS_M, keepout=zones).graph,
        f"{one.name}, our roadmap": straight_graph(roadmap),
    }
    rows = []
    for name, graph in graphs.items():
        audit = planner.audit(graph, scene, RADIUS_M, keepout=zones)
        coverage = planner.measure_coverage(audit, joined, REACH_M)
        rows.append(_row(name, audit, coverage, _detours(graph, audit, roadmap)))
        if pictures is not None:
            pictures.mkdir(parents=True, exist_ok=True)
            file = pictures / f"{name.replace(', ', '-').replace(' ', '-')}.png"
            save_drawing(file, audit_drawing(audit, scene, zones))
    return rows


def _row(name: str, audit: GraphAudit, coverage: GraphCoverage, detours: list[float]) -> str:
    least = float(audit.clearances.min())
    if audit.zone_clearances is not None:
        least = min(least, float(audit.zone_clearances.min()))
    counts = [str(len(audit.of(severity))) for severity in ("unsafe", "error", "warning")]
    values = [
        name,
        str(len(audit.graph.nodes)),
        str(len(audit.edges)),
        f"{least:.2f} m",
        *counts,
        f"{coverage.covered:.0%}",
        _metres(coverage.farthest),
        _metres(coverage.mean_to_node),
        _metres(coverage.farthest_to_node),
        f"{coverage.connected_pairs:.0%}",
        f"{np.mean(detours):.2f}",
        f"{max(detours):.2f}",
    ]
    return f"| {' | '.join(values)} |"


def _metres(length: float | None) -> str:
    return "-" if length is None else f"{length:.1f} m"


def _detours(graph: RouteGraph, audit: GraphAudit, roadmap: planner.Roadmap) -> list[float]:
    """Length of paths on the graph over the planner's shortest, for random pairs of nodes."""
    ways: nx.DiGraph[object] = nx.DiGraph()
    for edge, line in zip(audit.edges, audit.lines, strict=True):
        ways.add_edge(edge.start, edge.end, weight=length_of(line))
    place = {node.id: (node.x, node.y) for node in graph.nodes}
    nodes = sorted(ways, key=str)
    rng = np.random.default_rng(1)
    found: list[float] = []
    while len(found) < PAIRS:
        a, b = (nodes[int(k)] for k in rng.choice(len(nodes), 2, replace=False))
        shortest = roadmap.plan(place[a], place[b], prefer="length")  # type: ignore[index]
        if isinstance(shortest, planner.NoPath):
            if audit.safe:
                raise RuntimeError(f"no path from node {a} to {b}: {shortest.reason}")
            continue
        if shortest.length < 2.0 * RADIUS_M:
            continue
        found.append(nx.shortest_path_length(ways, a, b, weight="weight") / shortest.length)
    return found


PAGE: Final = """# Nav2's graphs, audited

Nav2 ships three route graphs with maps of them. Here is what `clearway audit` says about each
of them, about the same graph after `--repair`, and about the graph that `clearway roadmap`
makes of the same map, for a robot with a radius of {radius:g} m and with Nav2's own keep-out
masks. The files are those of navigation2 at `{commit}`.

{head}
{rows}

*Least clearance* is to obstacles and zones; 0 means that an edge runs through one. *Covered* is
the share of the free space from which the robot can reach the graph within {reach:g} m;
*farthest* is the longest such path, and `-` if a place has none. *To a node* and *farthest to
one* are SWAGGER's mean and largest distances from free places to the nearest node, and
*connected* its share of pairs of nodes with a path. *Detour* is the length of the shortest path
on the graph over that of the planner's shortest path, on average of {pairs} pairs of nodes, and
*worst* the largest. Our graphs have no dead ends shorter than {branch:g} m (`--least-branch`).

A person who draws a graph for a task covers what the task needs: a low coverage is no fault. An
edge in a keep-out zone is one.

This page is made by a command, which fetches Nav2's files or reads them from a Git repository,
and draws each audit:

```sh
python -m benchmarks.audit.gallery --pictures gallery
```

[Audit a route graph](audit.md) explains the findings.
"""


if __name__ == "__main__":
    main()
