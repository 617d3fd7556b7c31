"""Everything that the page says in numbers, measured once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import planner
import vision
from benchmarks.paper import arena as arenas
from benchmarks.paper import guarantees, inputs, insertion, timing, weaknesses
from benchmarks.paper.weaknesses import MODES, Mode, Taken

NOISES = (0.0, 5.0, 10.0, 20.0)
CIRCLE_RADII = (5.0, 12.0, 30.0)
OCTAGON_RADII = (5.0, 8.0, 12.0, 30.0)
ARC_RADII = (8.0, 12.0, 20.0, 40.0)
SPACINGS = (8.0, 4.0, 2.0, 1.0, 0.5)
PER_RADIUS = (0.5, 1.0, 1.5, 1.9)


@dataclass(frozen=True, slots=True)
class Measured:
    """The numbers, in the order of the page. Keys of two are (parameter, mode)."""

    arena: inputs.Picture
    kinds: Mapping[Mode, tuple[int, int, int]]
    reductions: tuple[arenas.Reduction, arenas.Reduction]
    walk_agrees: bool
    rows: Sequence[timing.Row]
    line_floor: float
    corner_values: Mapping[float, float]
    corners: Mapping[tuple[float, Mode], weaknesses.Corners]
    circles: Mapping[tuple[float, float, Mode], Taken]
    literal_discs: Taken
    octagons: Mapping[tuple[float, Mode], Taken]
    ratios: Mapping[str, float]
    protrusions: Mapping[tuple[float, Mode], float]
    clearances: Sequence[guarantees.Clearances]
    errors: Sequence[guarantees.BisectorError]
    completeness: Mapping[Mode, guarantees.Completeness]

    @property
    def spacing(self) -> float:
        """The delta of figure 5 and of Table 1, px."""
        return self.reductions[0].spacing


def measure(largest: int) -> Measured:
    """All of it; Table 1 up to ``largest`` border pixels. The timed part comes first."""
    picture = inputs.arena_picture()
    reductions = arenas.reduce(picture)
    rows = timing.table(reductions[0].spacing, largest)
    return Measured(
        arena=picture,
        kinds={mode: arenas.kinds(vision.extract(picture.image, mode=mode)) for mode in MODES},
        reductions=reductions,
        walk_agrees=walk_agrees(),
        rows=rows,
        line_floor=weaknesses.line_floor(),
        corner_values={a: weaknesses.corner_value(a) for a in (90.0, 120.0, 150.0, 165.0)},
        corners={(n, m): weaknesses.corners(n, m) for n in NOISES for m in MODES},
        circles={
            (r, n, m): weaknesses.circles(r, n, m)
            for r in CIRCLE_RADII
            for n in (0.0, 5.0, 20.0)
            for m in MODES
        },
        literal_discs=weaknesses.literal_discs(12.0),
        octagons={(r, m): weaknesses.octagons(r, 0.0, m) for r in OCTAGON_RADII for m in MODES},
        ratios={
            name: weaknesses.eigenvalue_ratio(shape)
            for name, shape in weaknesses.ratio_shapes().items()
        },
        protrusions={(r, m): weaknesses.protrusion(r, m) for r in ARC_RADII for m in MODES},
        clearances=[guarantees.clearances(k) for k in PER_RADIUS],
        errors=[guarantees.bisector_error(d, m) for d in SPACINGS for m in MODES],
        completeness={m: guarantees.completeness(m, guarantees.scenes_to_judge()) for m in MODES},
    )


def walk_agrees() -> bool:
    """Whether the paper's walk and the kernel give the 15th site the same neighbours."""
    sites, new = inputs.fourteen_sites(), inputs.fifteenth_site()
    walked = insertion.walk_around(planner.voronoi(sites), new)
    return set(walked.around) == insertion.new_region(new, sites)[0]
