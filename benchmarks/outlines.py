"""Every record against its border, over pictures that are hard to follow: how many fail.

Run ``python -m benchmarks.outlines [--count 200] [--only slits,real,round]``: prints a row a family
and the worst of each. ``real`` takes the pictures of the folder in ``CLEARWAY_REAL_DATA``. The
judge is ``tests.support.drawn.outline_judge``, the pictures are those of
``tests.support.drawn.outline_pictures``.
Nothing is kept: the wanted result is 0 in the last three columns.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.support.drawn.outline_judge import FEW_PX, Verdict, judge, mask_of
from tests.support.drawn.outline_pictures import FAMILIES, Picture, every_look, slits
from vision import PictureError, extract

SEED = 31
KINDS = (".jpg", ".png", ".pgm")
Polarity = Literal["dark", "light", "auto"]
Case = tuple[str, Picture, Polarity]


def slit_cases(count: int) -> Iterator[Case]:
    for i in range(count):
        yield f"slits {i}", slits(np.random.default_rng([SEED, i])), "dark"


def real_cases() -> Iterator[Case]:
    folder = os.environ.get("CLEARWAY_REAL_DATA")
    files = sorted(p for p in Path(folder).rglob("*") if p.suffix in KINDS) if folder else []
    if not files:
        print("CLEARWAY_REAL_DATA names no pictures: real is left out")
    for file in files:
        picture = cv2.imread(str(file))
        for polarity in ("dark", "light", "auto"):
            yield f"{file.name} {polarity}", picture, polarity


def cases(family: str, count: int) -> Iterator[Case]:
    if family == "slits":
        yield from slit_cases(count)
    elif family == "real":
        yield from real_cases()
    else:
        # as many pictures as asked for, or a little more: every mask is shown in every look
        for name, picture, look in every_look(family, max(1, count // 14), SEED):
            yield name, picture, look.polarity


def look_at(name: str, picture: Picture, polarity: Polarity) -> list[Verdict]:
    """The verdicts on a picture's records; none where it has no free pixel."""
    try:
        scene = extract(picture, polarity=polarity)
    except PictureError:
        return []
    return judge(mask_of(picture, polarity), scene)


def row(family: str, count: int, limit_px: float, shown: int) -> str:
    pictures = records = failed = hit = 0
    worst = 0.0
    told: list[tuple[float, str]] = []
    for name, picture, polarity in cases(family, count):
        verdicts = look_at(name, picture, polarity)
        bad = [v for v in verdicts if v.fails(limit_px)]
        pictures += 1
        records += len(verdicts)
        failed += len(bad)
        hit += bool(bad)
        for v in verdicts:
            worst = max(worst, v.outline_px, v.border_px)
        told += [(max(v.outline_px, v.border_px), f"{name}: {v}") for v in bad]
    for _, sentence in sorted(told, reverse=True)[:shown]:
        print(f"  {sentence}")
    return f"| {family} | {pictures} | {records} | {hit} | {failed} | {worst:.1f} |"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200, help="pictures a family")
    parser.add_argument("--only", default="", help="families, separated by commas")
    parser.add_argument("--limit", type=float, default=FEW_PX, help="pixels apart")
    parser.add_argument("--show", type=int, default=3, help="failures that are printed a family")
    given = parser.parse_args()
    families = given.only.split(",") if given.only else ["slits", "real", *FAMILIES]
    rows = [row(family, given.count, given.limit, given.show) for family in families]
    print("| family | pictures | records | pictures that fail | records that fail | worst px |")
    print("|---|---|---|---|---|---|")
    print("\n".join(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
