"""The counts of the code with their limits, and the picture of its folders.

    python -m benchmarks.house [--list] [--format text|json]
    python -m benchmarks.house --graph docs/pictures/folders.svg

Prints a row a figure: the count, the most that it may be, and whether that holds; ``--list`` adds
what was found and where. ``--graph`` draws who imports whom. Nothing is imported and nothing
compiled, only read. Ends with 1 where a limit is broken. What ruff and import-linter hold
(parameters, complexity, circles) is not counted again.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path

from benchmarks.house.drawing import drawn
from benchmarks.house.figures import Figure, figures
from benchmarks.house.tree import PACKAGES

ROOT = Path(__file__).resolve().parents[2]


def table(found: list[Figure]) -> list[str]:
    rows = ["| figure | count | at most | holds |", "|---|---|---|---|"]
    for one in found:
        most = "any" if one.most is None else one.most
        rows.append(f"| {one.name} | {len(one.found)} | {most} | {'yes' if one.holds else 'no'} |")
    return rows


def lists(found: list[Figure]) -> list[str]:
    rows = []
    for one in found:
        if one.found:
            rows += ["", f"{one.name}:", *(f"- {sentence}" for sentence in one.found)]
    return rows


def main(words: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.house", description=__doc__)
    parser.add_argument("--list", action="store_true", help="what was found, and where")
    parser.add_argument("--format", choices=("text", "json"), default="text")
    parser.add_argument("--graph", type=Path, help="draw the folders into this SVG file instead")
    parser.add_argument("--root", type=Path, default=ROOT, help="the folder to count in")
    options = parser.parse_args(words)
    root = options.root.resolve()
    if options.graph is not None:
        options.graph.write_text(drawn(PACKAGES), encoding="utf-8")
        return 0
    found = figures(root)
    if options.format == "json":
        print(json.dumps([{**asdict(one), "holds": one.holds} for one in found], indent=2))
    else:
        print("\n".join(table(found) + (lists(found) if options.list else [])))
    return 0 if all(one.holds for one in found) else 1


if __name__ == "__main__":
    sys.exit(main())
