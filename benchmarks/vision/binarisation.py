"""What each stage of binarisation earns: switched off alone, or its numbers changed, what falls.

Run ``python -m benchmarks.vision.binarisation [--count 4] [--only dots,colours] [--numbers]``. The
pictures: those of ``benchmarks.vision.regions`` that limits are set by, of the counts and ramps of
``python -m benchmarks.vision``, discs that colours tell, and the real pictures below
``CLEARWAY_REAL_DATA`` where that is set. A picture is right where every obstacle is one region and
no region is nobody's; of the real ones the share of pixels counts that are as they are with all
stages. ``--numbers`` doubles and halves each named number of ``vision.binarise`` instead, and says
which change nothing; kernels are compiled for that. Without ``--only`` and ``--numbers`` the table
is kept in ``docs/binarisation.md``.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import math
import multiprocessing
import os
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path, PurePosixPath
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.house.constants import named_numbers
from benchmarks.house.tree import File
from benchmarks.vision.compiled_again import compile_again
from benchmarks.vision.counts import discs
from benchmarks.vision.pictures import SEED, arena, taken
from benchmarks.vision.regions import FAMILIES, TUNING, Drawn, drawn, looked_at
from tests.support.drawn.render import coverage, outline_points, ramp
from vision import PictureError
from vision.binarise import colour
from vision.binarise.grey_picture import FEWEST_SAMPLES, NO_SMOOTHING
from vision.binarise.regions import edge_evidence
from vision.shared.array_pool import ArrayPool

Side = Literal["dark", "light"]
ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "binarisation.md"
BEGIN, END = "<!-- benchmarks.vision.binarisation -->\n", "<!-- end -->\n"
"""What the kept table stands between."""
BINARISE = "vision.binarise"
ADDED = edge_evidence.with_left_out
PROCESSES = multiprocessing.get_context("fork")
COLOURS = (
    ((0, 0, 200), (0, 102, 0)),
    ((220, 40, 40), (30, 74, 92)),
    ((30, 215, 235), (225, 225, 225)),
    ((60, 160, 60), (116, 116, 116)),
)
"""Obstacle and floor, blue, green and red."""


def no(*_: Any, **__: Any) -> bool:
    return False


def yes(*_: Any, **__: Any) -> bool:
    return True


def nothing(*_: Any, **__: Any) -> None:
    return None


def no_level(*_: Any) -> tuple[None, int]:
    return None, FEWEST_SAMPLES


def first(value: Any, *_: Any) -> Any:
    return value


def its_binary(judged: Any, *_: Any) -> Any:
    return judged.binary


def without_others(judged: Any, _: Any, support: Any) -> Any:
    return ADDED(judged, (), support)


@dataclass(frozen=True, slots=True)
class Case:
    """A picture, what it shows (a count, or where), and on which side of the level."""

    section: str
    picture: NDArray[np.uint8]
    shows: Drawn | int | None
    side: Side = "dark"


def cases(count: int) -> Iterator[Case]:
    """The pictures, ``count`` a family."""
    for number, (name, family) in enumerate(FAMILIES.items()):
        for i in range(count):
            one = drawn(family, np.random.default_rng([TUNING, number, i]))
            yield Case(name, one.picture, one)
    for noise in (0.0, 5.0, 10.0, 20.0):
        for i in range(count):
            rng = np.random.default_rng([SEED + 1, i, int(noise)])
            objects = int(rng.integers(3, 25))
            picture = taken(arena((640, 480), objects, i), noise, rng)
            yield Case(f"count, noise {noise:.0f}", picture, objects)
    yield from ramps(max(1, count // 2))
    for obstacle, floor in COLOURS:
        for i in range(count):
            yield Case("colours", coloured(obstacle, floor, i), 12)
    data = os.environ.get("CLEARWAY_REAL_DATA")
    if data:
        for file in sorted(p for p in Path(data).rglob("*") if p.suffix in (".jpg", ".png")):
            picture = cv2.imread(str(file))
            assert picture is not None
            yield Case("real", picture, None, "light" if "silhouette" in file.name else "dark")


def ramps(count: int) -> Iterator[Case]:
    size = (640, 480)
    for share in (0.0005, 0.01, 0.3):
        for i in range(count):
            scene = discs(size, share, np.random.default_rng([SEED + 1, i]))
            cover = coverage([outline_points(d) for d in scene], size, lines=4)
            for fall in (0.0, 0.8):
                for noise in (0.0, 10.0, 20.0):
                    rng = np.random.default_rng([SEED + 1, i, int(noise)])
                    lit = ramp(size, fall, rng.uniform(0.0, math.tau))
                    ends: dict[Side, tuple[float, float]]
                    ends = {"dark": (40.0, 215.0), "light": (215.0, 40.0)}
                    for side, (dark, light) in ends.items():
                        grey = cv2.GaussianBlur(light + (dark - light) * cover, (0, 0), 0.7) * lit
                        grey += rng.normal(0.0, noise, grey.shape)
                        picture = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
                        yield Case(f"ramp, {side}, noise {noise:.0f}", picture, len(scene), side)


def coloured(
    obstacle: tuple[int, int, int], floor: tuple[int, int, int], number: int
) -> NDArray[np.uint8]:
    """Twelve discs that colour tells from the floor; every other picture in uneven light."""
    rng = np.random.default_rng([SEED, number])
    size = (320, 240)
    scene = discs(size, rng.uniform(0.02, 0.2), rng)
    cover = coverage([outline_points(d) for d in scene], size, lines=4)
    cover = cv2.GaussianBlur(cover, (0, 0), 0.7)[:, :, None]
    lit = ramp(size, 0.4 * (number % 2), rng.uniform(0.0, math.tau))[:, :, None]
    seen = (cover * np.array(obstacle, float) + (1.0 - cover) * np.array(floor, float)) * lit
    seen += rng.normal(0.0, 4.0 * (number % 3), seen.shape)
    return np.asarray(np.clip(np.rint(seen), 0, 255), dtype=np.uint8)


def mask_of(case: Case) -> NDArray[np.uint8]:
    """The mask (h, w), without its margin; all obstacle where there is no free space."""
    try:
        return colour.binarise_by_colour(
            case.picture, polarity=case.side, method="auto", threshold=None, ignore=None,
            pool=ArrayPool(),
        ).inside  # fmt: skip
    except PictureError:
        return np.ones(case.picture.shape[:2], np.uint8)


@dataclass(frozen=True, slots=True)
class Figures:
    """Sums over all pictures, and per section how many are right."""

    found: tuple[int, int]
    false: int
    overlap: float
    right: Counter[str]
    real: list[NDArray[np.uint8]]

    def row(self, name: str, usual: Figures) -> str:
        drawn_right = sum(self.right[one] for one in FAMILIES)
        others = sum(self.right.values()) - drawn_right
        fell = {one: usual.right[one] - self.right[one] for one in usual.right}
        most = sorted((one for one in fell if fell[one]), key=lambda one: -fell[one])
        said = "; ".join(f"{one} {-fell[one]:+d}" for one in [*most[:4], *most[4:][-2:]])
        return (
            f"| {name} | {self.found[0]} | {self.found[1]} | {self.false} | {self.overlap:.4f} "
            f"| {drawn_right} | {others} | {alike(self.real, usual.real)} | {said} |"
        )


def alike(masks: list[NDArray[np.uint8]], usual: list[NDArray[np.uint8]]) -> str:
    """How many of the real pictures differ in more than a thousandth of their pixels."""
    return str(sum(float((a != b).mean()) > 0.001 for a, b in zip(masks, usual, strict=True)))


def figures(all_cases: list[Case]) -> Figures:
    plain = faint = false = 0
    overlaps, real = [], []
    right: Counter[str] = Counter()
    for case in all_cases:
        inside = mask_of(case).copy()
        right[case.section] += 0
        if case.shows is None:
            real.append(inside)
        elif isinstance(case.shows, int):
            right[case.section] += cv2.connectedComponents(inside)[0] - 1 == case.shows
        else:
            found, nobodys = looked_at(case.shows, inside)
            plain += sum(f and not g for f, g in zip(found, case.shows.faint, strict=True))
            faint += sum(f and g for f, g in zip(found, case.shows.faint, strict=True))
            false += nobodys
            right[case.section] += all(found) and not nobodys
            truth = np.zeros(inside.shape, np.bool_)
            for cover in case.shows.obstacles:
                truth |= cover
            both = int((truth | (inside != 0)).sum())
            overlaps.append(float((truth & (inside != 0)).sum() / both) if both else 1.0)
    return Figures((plain, faint), false, float(np.mean(overlaps)), right, real)


Change = tuple[str, Any]
"""A place, ``package.module.name`` below ``vision.binarise``, and what stands there instead."""
STAGES: dict[str, tuple[Change, ...]] = {
    "even light taken at once": (("binarise.follows_edges", no),),
    "does the level follow edges?": (("binarise.follows_edges", yes),),
    "steps too weak for the classes": (("regions.edge_evidence.WEAK_STEP", -1.0),),
    "steps too strong for them": (("regions.edge_evidence.STRONG_STEP", 1e9),),
    "does the level leave edges out?": (("binarise.leaves_out", no),),
    "how much free pixels spread": (("binarise.MOST_UNEVEN", 1e9),),
    "less of it in noise": (("binarise.SURELY_EVEN", 1e9),),
    "classes set right where most is edge": (("grey_classes._sharpened", first),),
    "classes of rare pixels": (("grey_classes._rare_pixels", nothing),),
    "what stands out of uneven noise": (("grey_classes.significant_dark", nothing),),
    "the level that edges speak for": (
        ("regions.edge_evidence.EdgeEvidence.best_level", no_level),
    ),
    "smoothing before the level": (("grey_picture.SMOOTHINGS", (NO_SMOOTHING,)),),
    "smoothing before the judge": (("grey_picture.SMOOTHED_NOISE", 1e9),),
    "dots": (("grey_picture.mark_dots", nothing),),
    "missed obstacles": (("binarise.with_left_out", its_binary),),
    "masks of the other candidates": (("binarise.with_left_out", without_others),),
    "specks of them in the mask": (("regions.edge_evidence.SPECKS", 0.0),),
    "judge: sigmas": (("regions.judge.SIGMAS", 0.0),),
    "judge: what a level draws in noise": (("regions.judge.SELECTED", 0.0),),
    "judge: all sides": (("regions.judge.SHORT_SIDE", 2.0),),
    "judge: but short ones": (("regions.judge.SHORT_SIDE", 0.0),),
    "judge: sharp": (("regions.judge.LEAST_SHARP", -9.0),),
    "judge: half the picture out of focus": (("regions.judge.OUT_OF_FOCUS", 1e9),),
    "judge: half the typical share": (("regions.judge.FAINT", 0.0),),
    "judge: thick": (("regions.judge.THICK_PX", 0.0),),
    "judge: or thin, with more": (("regions.judge.THIN_SHARE", 9.0),),
    "colours": (("colour._Colours.of", nothing),),
    "specks of colour": (("colour._without_specks", first),),
}


def change(place: str, value: Any) -> None:
    """Let something else stand at a place, in every module that has the name from there."""
    path, _, name = f"{BINARISE}.{place}".rpartition(".")
    if path in sys.modules:
        owner: Any = sys.modules[path]
    else:
        module, _, of = path.rpartition(".")
        owner = getattr(sys.modules[module], of)
    old = getattr(owner, name)
    for other in [owner, *(m for n, m in sys.modules.items() if n.startswith("vision."))]:
        if other is owner or getattr(other, name, None) is old:
            setattr(other, name, value)


def changed(all_cases: list[Case], changes: tuple[Change, ...]) -> Figures:
    """The figures with changes, from a process of their own: nothing was compiled before."""
    here, there = PROCESSES.Pipe(duplex=False)
    with tempfile.TemporaryDirectory() as folder:
        child = PROCESSES.Process(target=_tell, args=(there, all_cases, changes, folder))
        child.start()
        there.close()
        try:
            found: Figures = here.recv()
        finally:
            child.join()
    return found


def _tell(
    there: Connection, all_cases: list[Case], changes: tuple[Change, ...], folder: str
) -> None:
    for place, value in changes:
        change(place, value)
    if any("_kernels." in place for place, _ in changes):
        compile_again(BINARISE, folder)  # numbers are compiled into it
    there.send(figures(all_cases))


def numbers() -> dict[str, float]:
    """The named numbers of binarisation that are one number each, by their places."""
    found: dict[str, float] = {}
    for path in sorted((ROOT / "vision" / "binarise").rglob("*.py")):
        place = PurePosixPath(path.relative_to(ROOT))
        text = path.read_text(encoding="utf-8")
        file = File(place, text, ast.parse(text))
        for one in named_numbers([file]):
            value = getattr(importlib.import_module(file.module), one.name)
            if one.source != "defined" and isinstance(value, int | float):
                found[f"{file.module}.{one.name}".removeprefix(f"{BINARISE}.")] = value
    return found


HEAD = (
    "| switched off | plain found | faint found | false regions | overlap | pictures right "
    "| counts, ramps, colours right | real pictures that differ | where |\n"
    "|---|---|---|---|---|---|---|---|---|"
)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=4, help="pictures a family")
    parser.add_argument("--only", default="", help="stages, separated by commas")
    parser.add_argument(
        "--numbers", default=None, nargs="?", const="", help="those whose place has"
    )
    given = parser.parse_args()
    cv2.setNumThreads(1)
    drawings = list(cases(given.count))
    usual = changed(drawings, ())
    rows = [usual.row("nothing", usual)]
    print(f"{HEAD}\n{rows[0]}", flush=True)
    if given.numbers is not None:
        for place, value in numbers().items():
            for factor in (0.5, 2.0) if given.numbers in place else ():
                other = type(value)(factor * value)
                try:
                    row = changed(drawings, ((place, other),)).row(f"{place} = {other:g}", usual)
                except EOFError:  # a share beyond all, say
                    row = f"| {place} = {other:g} | ends with an error |"
                print(row, flush=True)
        return 0
    for name in given.only.split(",") if given.only else STAGES:
        rows.append(changed(drawings, STAGES[name]).row(name, usual))
        print(rows[-1], flush=True)
    if not given.only:
        text = PAGE.read_text(encoding="utf-8")
        before, rest = text.split(BEGIN)
        behind = rest.split(END)[1]
        table = "\n".join((f"{given.count} pictures a family.\n", HEAD, *rows))
        PAGE.write_text(f"{before}{BEGIN}{table}\n{END}{behind}", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
