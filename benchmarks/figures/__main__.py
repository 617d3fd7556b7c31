"""Draw the figures of the documents: `python -m benchmarks.figures [--output docs/pictures]`."""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.figures import diagram, outlines

FIGURES = {
    "outline-points.svg": outlines.points_figure,
    "outline-partition.svg": outlines.partition_figure,
    "outline-corners.svg": outlines.corners_figure,
    "outline-drawn.svg": outlines.drawn_figure,
    "diagram-sampled.svg": diagram.sampled_figure,
    "diagram-solved.svg": diagram.solved_figure,
    "diagram-refined.svg": diagram.refined_figure,
}


def main() -> None:
    """Draw and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=Path("docs/pictures"))
    folder: Path = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in FIGURES.items():
        (folder / name).write_text(draw(), encoding="utf-8")
    print(f"{folder}: {len(FIGURES)} figures")


if __name__ == "__main__":
    main()
