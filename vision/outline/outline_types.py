"""Types that the fitting kernels pass on: a border's points, its edges, and their costs.

Rules and units
- Pixels (or rectified pixels), y down, about the border's own origin (see
  ``vision.outline.canonical_frame_kernels``).
- Arrays are C-contiguous, and may be longer than the part in use, which numbers beside them give.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class BorderPoints(NamedTuple):
    """One border's points, a closed sequence, or the middles of its cracks.

    ``x``, ``y`` (2 n + 1,) float64: the ``n`` points twice and the first once more, so that a
    stretch may run past the border's end once.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    n: int


class Cracks(NamedTuple):
    """One border's cracks.

    ``x``, ``y`` (2 n + 1,) float64: the middles of the ``n`` cracks, twice as in ``BorderPoints``;
    ``free_x``, ``free_y``: from there to the free pixel's centre. ``n`` is 0 unless the picture is
    bilevel: then edges must separate its pixels.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    free_x: NDArray[np.float64]
    free_y: NDArray[np.float64]
    n: int


class CrackPixels(NamedTuple):
    """Cracks of all borders, as in ``vision.borders.contours.Contours``.

    ``x``, ``y`` (k,): the obstacle pixels; ``direction`` (k,): the free one's; ``starts`` (borders
    + 1,).
    """

    x: NDArray[np.int32]
    y: NDArray[np.int32]
    direction: NDArray[np.int8]
    starts: NDArray[np.int64]


class CanonicalPlace(NamedTuple):
    """Original position of a border that was moved into its canonical frame.

    ``transposed``: x and y were exchanged before ``turns`` quarter turns; ``x``, ``y``: its origin
    after both.
    """

    transposed: bool
    turns: int
    x: float
    y: float


class Outline(NamedTuple):
    """Edges of one border during the fit; their number is passed beside it.

    ``breaks`` (edges,) int64: each edge's first point; it ends at the next one's. ``is_arc``,
    ``is_fillet`` (edges,) bool. ``shape`` (edges, 5) float64: x, y, ux, uy of a line or cx, cy, r
    of a circle, and the rms deviation last. ``joints`` (edges, 2) float64: the edge's beginning.
    ``ranges`` (edges, 2) int64: first point of its fit, and the one behind the last. ``fresh``
    (edges, 2) bool: the edge was fitted again, its break moved; ``moved`` (edges,) int64: the new
    break.
    """

    breaks: NDArray[np.int64]
    is_arc: NDArray[np.bool_]
    is_fillet: NDArray[np.bool_]
    shape: NDArray[np.float64]
    joints: NDArray[np.float64]
    ranges: NDArray[np.int64]
    fresh: NDArray[np.bool_]
    moved: NDArray[np.int64]


class FinishedEdges(NamedTuple):
    """Edges as written (see ``vision.outline.fit.outline_kernels``).

    ``kind`` (k,) int8: LINE, ARC_CW or ARC_CCW. ``rows`` (k, 6) float64: the first point x, y, the
    centre and radius of an arc, and the rms deviation. ``at`` (k,) int64: the edge's first point or
    crack, if known.
    """

    kind: NDArray[np.int8]
    rows: NDArray[np.float64]
    at: NDArray[np.int64]


class Review(NamedTuple):
    """Findings of a check of finished edges.

    ``ragged`` (edges,) bool: chords must replace the edge; ``losses`` (edges,) float64: the area
    that it loses, square pixels; ``stale`` (edges,) bool: to be finished again.
    """

    ragged: NDArray[np.bool_]
    losses: NDArray[np.float64]
    stale: NDArray[np.bool_]


class Costs(NamedTuple):
    """Cost of a point's deviation: ((deviation - dead_zone) / sigma)^2 beyond the dead zone.

    ``crisp``: deviations are along the pixels' axis; ``dead_zone``, ``sigma`` and ``worst``, the
    largest allowed, in pixels; ``expected``: a point's mean cost from noise alone.
    """

    crisp: bool
    dead_zone: float
    sigma: float
    worst: float
    expected: float


class Prices(NamedTuple):
    """Saving required of a line, an arc and a whole circle (``vision.outline.fit.edge_prices``)."""

    line: float
    arc: float
    circle: float


class OutlineLimits(NamedTuple):
    """Limits on what edges may miss, in pixels (``vision.outline.limit_kernels``).

    ``crisp``: without grey. ``worst``: largest distance of a point from its edge, ``round_worst``:
    from a whole circle. ``seeds``: distance of the first chords from the border. ``skip``: points
    left out at a stretch's ends in the search, ``guard``: pixels in a fit. ``corner_blur``:
    rounding of a corner; ``tangent``: gap allowed between smoothly joined edges. ``free``:
    deviation that loses no area, ``allowed``: the most that an edge may have; ``chord``: distance
    of a chord from its points. ``expected`` as in ``Costs``.
    """

    crisp: bool
    worst: float
    round_worst: float
    seeds: float
    skip: int
    guard: float
    corner_blur: float
    tangent: float
    free: float
    allowed: float
    chord: float
    expected: float


class Search(NamedTuple):
    """State of the search for the cheapest partition; m seeds, the first repeated as the last.

    ``position`` (m + 1,) int64: the seeds' points from the first break on; ``rest``, ``best`` (m +
    1,) float64: least cost of the edges from there on, and least known cost up to there; ``came``
    (m + 1,) int64: the seed before, -1 for none; ``arc`` (m + 1,) bool: an arc leads from it.
    """

    position: NDArray[np.int64]
    rest: NDArray[np.float64]
    best: NDArray[np.float64]
    came: NDArray[np.int64]
    arc: NDArray[np.bool_]


class StretchFit(NamedTuple):
    """Fit of the search's last stretch.

    ``sums`` as in ``vision.outline.fit.moment_kernels``; ``line`` (4,), ``circle`` (3,) float64;
    ``near`` (2, k) float64: scratch space for points.
    """

    sums: NDArray[np.float64]
    line: NDArray[np.float64]
    circle: NDArray[np.float64]
    near: NDArray[np.float64]


class Blur(NamedTuple):
    """Effect of blur on a border, in pixels.

    ``sigma``: with the pixel's own width; ``half_variance``: an arc's shift inwards times its
    radius, square pixels; ``guard``: distance to which a corner is rounded.
    """

    sigma: float
    half_variance: float
    guard: float


class EdgeChange(NamedTuple):
    """A possible change between two edges that stay: their corner, or one edge.

    ``rows`` (3, 8) float64: the edges before, between and behind, as in ``Outline.shape``;
    ``joints`` (2, 8): x, y of both ends of the one between; ``corners`` (2, 8): see
    ``vision.outline.corners.blurred_corner_kernels``; ``meeting`` (8,): the crossing of both that
    stay (``vision.outline.corners.fillet_kernels.set_corner``). ``stays`` (4,) int64: first point
    and point behind the last of each edge that stays; ``points`` (4,) int64: the first point
    compared, the first of the edge between, those behind both. ``deviations`` (2 n + 1,): scratch
    space.
    """

    rows: NDArray[np.float64]
    joints: NDArray[np.float64]
    corners: NDArray[np.float64]
    meeting: NDArray[np.float64]
    stays: NDArray[np.int64]
    points: NDArray[np.int64]
    deviations: NDArray[np.float64]


class EdgeRun(NamedTuple):
    """Edges that an edit might replace: ``length`` of them between ``before`` and ``behind``.

    ``spare``: edges that the outline can spare; ``untouched``: it is as partitioned; ``convex``:
    edges turn to one side, not too far; ``bent``: surely not one line. ``price``: theirs;
    ``saved``: at most that plus the cost of points beside them.
    """

    before: int
    behind: int
    length: int
    spare: int
    untouched: bool
    convex: bool
    bent: bool
    price: float
    saved: float


class Edits(NamedTuple):
    """The best edit behind each edge.

    ``sums`` (2 n + 1,) float64: current cost of the points up to each one. ``saved`` (edges,)
    float64: the saving; ``run`` (edges,) int64: number of edges replaced; ``kind`` (edges,) int64:
    the replacement (``vision.outline.corners.edit_kernels``); ``first``, ``behind`` (edges,) int64:
    its first point, and the one behind its last.
    """

    sums: NDArray[np.float64]
    saved: NDArray[np.float64]
    run: NDArray[np.int64]
    kind: NDArray[np.int64]
    first: NDArray[np.int64]
    behind: NDArray[np.int64]


class Scratch(NamedTuple):
    """Scratch space for each step.

    ``numbers`` (7, 2 n + 1) float64, ``indices`` (7, 2 n + 1) int64, ``flags`` (5, 2 n + 1) bool: a
    step names its rows. ``pairs`` (n + 1, 2) int64, ``table`` (2 n, 8) float64.
    """

    numbers: NDArray[np.float64]
    indices: NDArray[np.int64]
    flags: NDArray[np.bool_]
    pairs: NDArray[np.int64]
    table: NDArray[np.float64]


class BorderMemory(NamedTuple):
    """Memory for one border, shared out by ``vision.outline.fitting_kernels.share_out``.

    ``most``: the largest number of points, plus one.
    """

    most: int
    numbers: NDArray[np.float64]
    indices: NDArray[np.int64]
    flags: NDArray[np.bool_]
    table: NDArray[np.float64]
    pairs: NDArray[np.int64]
    fresh: NDArray[np.bool_]
    kinds: NDArray[np.int8]


class Work(NamedTuple):
    """Memory to fit one border, sized for the longest.

    Allocated at once, so that everything below is a borrowing kernel
    (``planner.scene.compile_options``), in few arrays, as each lengthens compilation.

    ``places`` (6, 2 n + 1) float64: the arrays of ``BorderPoints``, then those of ``Cracks``.
    ``trial``: edges finished for a check; ``at`` (n,) int64: of those finally written. ``circle``
    (3,) float64: the one through the whole border.
    """

    places: NDArray[np.float64]
    outline: Outline
    trial: FinishedEdges
    review: Review
    at: NDArray[np.int64]
    circle: NDArray[np.float64]
    scratch: Scratch


class Fitted(NamedTuple):
    """Output arrays for all borders' edges.

    ``border_kind`` (b,) int8, ``edge_starts`` (b + 1,) int64, ``kind`` (k,) int8 and ``rows`` (k,
    6) float64 as in ``vision.outline.fitted_borders``.
    """

    border_kind: NDArray[np.int8]
    edge_starts: NDArray[np.int64]
    kind: NDArray[np.int8]
    rows: NDArray[np.float64]
