"""Time that the tests take: phases, folders, files and the slowest tests.

    python -m pytest --junitxml build/untimed.xml -n 3 --dist loadfile -m "not timed"
    python -m pytest --junitxml build/timed.xml -m timed
    python -m benchmarks.suite build/untimed.xml build/timed.xml

Each report is a phase. A test's processor time is its process's and that of every child that ended
meanwhile, so it does not depend on what else the computer does; a fixture that several tests share
counts for the first of them.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Final, NamedTuple
from xml.etree import ElementTree

SHOWN: Final = 20


class Case(NamedTuple):
    """One test of a report."""

    file: str
    name: str
    wall_s: float
    processor_s: float

    @property
    def folder(self) -> str:
        return "/".join(self.file.split("/")[:-1][:3])


class Phase(NamedTuple):
    """One run of pytest."""

    name: str
    wall_s: float
    cases: tuple[Case, ...]

    @property
    def processor_s(self) -> float:
        return sum(case.processor_s for case in self.cases)


def read_phase(path: Path) -> Phase:
    """The phase of one report."""
    suite = next(ElementTree.parse(path).getroot().iter("testsuite"))
    cases = tuple(_case(node) for node in suite.iter("testcase"))
    return Phase(path.stem, float(suite.attrib["time"]), cases)


def _case(node: ElementTree.Element) -> Case:
    modules = [part for part in node.attrib["classname"].split(".") if not part.startswith("Test")]
    spent = [p.attrib["value"] for p in node.iter("property") if p.attrib["name"] == "processor_s"]
    return Case(
        "/".join(modules) + ".py",
        node.attrib["name"],
        float(node.attrib["time"]),
        float(spent[0]) if spent else 0.0,
    )


def table(title: str, cases: Iterable[Case], key: Callable[[Case], str], shown: int) -> list[str]:
    """The groups of `cases` with most processor time, as a table in Markdown."""
    groups: defaultdict[str, list[Case]] = defaultdict(list)
    for case in cases:
        groups[key(case)].append(case)
    rows = [
        (sum(one.processor_s for one in group), sum(one.wall_s for one in group), len(group), name)
        for name, group in groups.items()
    ]
    lines = [f"| {title} | tests | processor s | wall s |", "|---|---|---|---|"]
    for spent_s, wall_s, count, name in sorted(rows, reverse=True)[:shown]:
        lines.append(f"| {name} | {count} | {spent_s:.1f} | {wall_s:.1f} |")
    return [*lines, ""]


def main(arguments: list[str] | None = None) -> None:
    """Print the tables of the reports that are named."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.suite", description=__doc__)
    parser.add_argument("reports", nargs="+", type=Path, metavar="REPORT.xml")
    parser.add_argument("--shown", type=int, default=SHOWN, help="rows of each table")
    asked = parser.parse_args(arguments)
    phases = [read_phase(path) for path in asked.reports]
    lines = ["| phase | tests | processor s | wall s |", "|---|---|---|---|"]
    for phase in phases:
        row = f"{len(phase.cases)} | {phase.processor_s:.0f} | {phase.wall_s:.0f}"
        lines.append(f"| {phase.name} | {row} |")
    lines.append("")
    cases = [case for phase in phases for case in phase.cases]
    lines += table("folder", cases, lambda case: case.folder, asked.shown)
    lines += table("file", cases, lambda case: case.file, asked.shown)
    lines += table("test", cases, lambda case: f"{case.file}::{case.name}", asked.shown)
    print("\n".join(lines))


if __name__ == "__main__":
    main()
