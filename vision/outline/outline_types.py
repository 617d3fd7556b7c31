"""What the kernels of the fit hand on: one border's points, its edges, and what they may cost.

Rules and units
- Pixels (or rectified pixels), y down, about the border's own origin (see
  ``vision.outline.canonical_frame_kernels``).
- Tuples of arrays and numbers, which cost a kernel nothing. Their arrays are C-contiguous and may
  be longer than what is in use: numbers beside them say how much that is. Whoever makes a tuple
  holds its arrays.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class BorderPoints(NamedTuple):
    """One border's points, a closed sequence, or the middles of its cracks.

    ``x``, ``y`` (2 n + 1,) float64: the ``n`` points twice over and the first once more, so that
    a stretch lo .. hi may run past the border's end once.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    n: int


class Cracks(NamedTuple):
    """One border's cracks, each between an obstacle pixel and a free one.

    ``x``, ``y`` (2 n + 1,) float64: the middles of the ``n`` cracks, twice over as in
    ``BorderPoints``; ``free_x``, ``free_y``: from there to the free pixel's centre. ``n`` is 0
    where edges need not separate pixels.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    free_x: NDArray[np.float64]
    free_y: NDArray[np.float64]
    n: int


class CrackPixels(NamedTuple):
    """The cracks of all borders as ``vision.borders.contours.Borders`` has them.

    ``x``, ``y`` (k,): the obstacle pixels; ``direction`` (k,): the free one's; ``starts``
    (borders + 1,).
    """

    x: NDArray[np.int32]
    y: NDArray[np.int32]
    direction: NDArray[np.int8]
    starts: NDArray[np.int64]


class Place(NamedTuple):
    """Where a border was before it was brought into the frame that it is fitted in.

    ``transposed``: x and y were exchanged, ``turns`` quarters it was turned by then; ``x``, ``y``
    is what its origin lies at after both.
    """

    transposed: bool
    turns: int
    x: float
    y: float


class Outline(NamedTuple):
    """The edges of one border while they are being fitted; their number is handed on beside it.

    ``breaks`` (edges,) int64: each edge's first point; it ends at the next one's. ``is_arc``,
    ``is_fillet`` (edges,) bool. ``shape`` (edges, 5) float64: x, y, ux, uy of a line or cx, cy, r
    of a circle, and the rms deviation last. ``joints`` (edges, 2) float64: where the edge begins.
    ``ranges`` (edges, 2) int64: the first point that took part in its fit, and the one behind the
    last. ``fresh`` (edges, 2) bool: whether it was fitted again, and whether its break moved;
    ``moved`` (edges,) int64: where to.
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
    """Edges as they are written (see ``vision.outline.fit.outline_kernels``).

    ``kind`` (k,) int8: LINE, ARC_CW or ARC_CCW. ``rows`` (k, 6) float64: the first point x, y, the
    centre and radius of an arc, and the rms deviation. ``at`` (k,) int64: the point or the crack
    that an edge begins at, where it is known.
    """

    kind: NDArray[np.int8]
    rows: NDArray[np.float64]
    at: NDArray[np.int64]


class Review(NamedTuple):
    """What a check of finished edges found.

    ``ragged`` (edges,) bool: edges that chords have to replace; ``losses`` (edges,) float64: the
    area that each loses, square pixels; ``stale`` (edges,) bool: to be finished again.
    """

    ragged: NDArray[np.bool_]
    losses: NDArray[np.float64]
    stale: NDArray[np.bool_]


class Costs(NamedTuple):
    """What a point's deviation costs: ((deviation - dead_zone) / sigma)^2 beyond the dead zone.

    ``crisp``: deviations are along the pixels' axis, as without grey; ``dead_zone``, ``sigma`` and
    ``worst``, the farthest that a point may lie from its edge, in pixels; ``expected``: what noise
    alone costs a point, in the mean.
    """

    crisp: bool
    dead_zone: float
    sigma: float
    worst: float
    expected: float


class Prices(NamedTuple):
    """What a line, an arc and a whole circle have to save (``vision.outline.fit.edge_prices``)."""

    line: float
    arc: float
    circle: float


class Limits(NamedTuple):
    """What a picture lets its edges miss, in pixels (``vision.outline.limit_kernels``).

    ``crisp``: without grey. ``worst``: the farthest point from its edge, ``round_worst``: from a
    whole circle. ``seeds``: how far the first chords may lie from the border. ``skip``: points left
    out at both ends of a stretch in the search, ``guard``: pixels in a fit. ``corner_blur``: how
    far a corner may be rounded; ``tangent``: by how much smoothly joined edges may miss each other.
    ``free``: a deviation that loses no area, ``allowed``: one that no edge may have; ``chord``: how
    far a chord may leave its points. ``expected`` as in ``Costs``.
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
    """The state of the search for the cheapest partition; m seeds, the first one again as the last.

    ``position`` (m + 1,) int64: the seeds' points from the first break on; ``rest``, ``best``
    (m + 1,) float64: what the edges from there on cost at least, and those up to there as far as
    known; ``came`` (m + 1,) int64: the seed before, -1 for none; ``arc`` (m + 1,) bool: whether an
    arc leads from there.
    """

    position: NDArray[np.int64]
    rest: NDArray[np.float64]
    best: NDArray[np.float64]
    came: NDArray[np.int64]
    arc: NDArray[np.bool_]


class StretchFit(NamedTuple):
    """What the search's last stretch was fitted by.

    ``sums`` as in ``vision.outline.fit.moment_kernels``; ``line`` (4,), ``circle`` (3,) float64;
    ``near`` (2, k) float64: room for points.
    """

    sums: NDArray[np.float64]
    line: NDArray[np.float64]
    circle: NDArray[np.float64]
    near: NDArray[np.float64]


class Blur(NamedTuple):
    """What blur does to a border, in pixels.

    ``sigma``: of the light and the pixel's own width together; ``half_variance``: by how much it
    moves an arc inwards, times the radius, square pixels; ``guard``: how far a corner is rounded.
    """

    sigma: float
    half_variance: float
    guard: float


class Change(NamedTuple):
    """What might be between two edges that stay: nothing but their corner, or one edge.

    ``rows`` (3, 8) float64: the edge before, the one between, the one behind, as in
    ``Outline.shape``; ``joints`` (2, 8): x, y where the one between begins and ends; ``corners``
    (2, 8): see ``vision.outline.corners.blurred_corner_kernels``; ``meeting`` (8,): where both
    that stay cross (``vision.outline.corners.fillet_kernels.set_corner``). ``stays`` (4,) int64:
    the first points of both that stay, and those behind their last, as they are; ``points`` (4,)
    int64: the first point compared, the first one of the edge between, those behind both.
    ``deviations`` (2 n + 1,): room.
    """

    rows: NDArray[np.float64]
    joints: NDArray[np.float64]
    corners: NDArray[np.float64]
    meeting: NDArray[np.float64]
    stays: NDArray[np.int64]
    points: NDArray[np.int64]
    deviations: NDArray[np.float64]


class Run(NamedTuple):
    """Edges that an edit might replace: ``length`` of them between ``before`` and ``behind``.

    ``spare``: how many edges the outline can do without; ``untouched``: it is as the partition left
    it; ``convex``: all turn to one side, and not too far; ``bent``: they are surely not one line.
    ``price``: theirs; ``saved``: that and what their points and those beside them cost, at most.
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
    """The best edit behind each edge: what takes the place of the edges that follow it.

    ``sums`` (2 n + 1,) float64: what the border's points up to each one cost as it is.
    ``saved`` (edges,) float64: what it saves; ``run`` (edges,) int64: how many edges it replaces;
    ``kind`` (edges,) int64: by what (``vision.outline.corners.edit_kernels``); ``first``,
    ``behind`` (edges,) int64: that edge's first point, and the one behind its last.
    """

    sums: NDArray[np.float64]
    saved: NDArray[np.float64]
    run: NDArray[np.int64]
    kind: NDArray[np.int64]
    first: NDArray[np.int64]
    behind: NDArray[np.int64]


class Scratch(NamedTuple):
    """Room that every step works in and none leaves anything in for the next.

    ``numbers`` (7, 2 n + 1) float64, ``indices`` (7, 2 n + 1) int64, ``flags`` (5, 2 n + 1) bool:
    a step takes rows of them under names of its own. ``pairs`` (n + 1, 2) int64, ``table`` (2 n, 8)
    float64.
    """

    numbers: NDArray[np.float64]
    indices: NDArray[np.int64]
    flags: NDArray[np.bool_]
    pairs: NDArray[np.int64]
    table: NDArray[np.float64]


class Memory(NamedTuple):
    """All that one border is fitted in, shared out by ``vision.outline.fitting_kernels.share_out``.

    Few arrays: a call from Python unpacks each of them. ``most``: so many points, and one more.
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
    """Memory to fit one border in, as long as the longest one needs.

    All of it is made at once, so that everything below is a borrowing kernel
    (``planner.scene.compile_options``), and is few arrays: a kernel is compiled the longer the more
    of them it is handed. As 60 of their own they were a third of the eye's compile time.

    ``places`` (6, 2 n + 1) float64: the arrays of ``BorderPoints``, then those of ``Cracks``.
    ``trial``: edges finished for a look at them; ``at`` (n,) int64: of those that are written at
    last. ``circle`` (3,) float64: the one through the whole border.
    """

    places: NDArray[np.float64]
    outline: Outline
    trial: FinishedEdges
    review: Review
    at: NDArray[np.int64]
    circle: NDArray[np.float64]
    room: Scratch


class Fitted(NamedTuple):
    """Where all borders' edges are written, one border after the other.

    ``border_kind`` (b,) int8, ``edge_starts`` (b + 1,) int64, ``kind`` (k,) int8 and ``rows``
    (k, 6) float64 as in ``vision.outline.fitted_borders``.
    """

    border_kind: NDArray[np.int8]
    edge_starts: NDArray[np.int64]
    kind: NDArray[np.int8]
    rows: NDArray[np.float64]
