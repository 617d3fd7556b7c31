"""Make docs/paper: `python -m benchmarks.paper [--largest 1e6] [--output docs/paper]`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from benchmarks.paper import arena, diagrams, guarantees, insertion, timing
from benchmarks.paper.measured import Measured, measure
from benchmarks.paper.page import TOP, page


def figures(m: Measured) -> dict[str, Callable[[], str]]:
    """Every figure by its file's name."""
    return {
        "figure-1.svg": insertion.figure_1,
        "figure-2.svg": insertion.figure_2,
        "figure-3.svg": diagrams.figure_3,
        "figure-4.svg": diagrams.figure_4,
        "figure-5.svg": lambda: arena.figure_5(m.arena, m.spacing),
        "figure-6.svg": lambda: timing.figure_6(m.rows),
        "figure-7.svg": lambda: guarantees.figure_7(m.errors),
    }


def main() -> None:
    """Measure, draw, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--largest", type=float, default=1e6, help="border pixels in Table 1")
    parser.add_argument("--output", type=Path, default=TOP / "docs" / "paper")
    given = parser.parse_args()
    folder: Path = given.output
    folder.mkdir(parents=True, exist_ok=True)
    measured = measure(int(given.largest))
    for name, draw in figures(measured).items():
        (folder / name).write_text(draw(), encoding="utf-8")
    (folder / "README.md").write_text(page(measured), encoding="utf-8")
    print(f"{folder}: README.md and {len(figures(measured))} figures")


if __name__ == "__main__":
    main()
