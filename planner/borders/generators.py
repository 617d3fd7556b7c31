"""Generators: points every delta along the borders of a scene (the paper's section 2.3.1).

Rules and units
- Scene's units. ``delta`` is called ``spacing`` here; it is less than twice the robot's radius, so
  that no robot fits between two neighbours.
- A generator has the label of its piece: the primitive it lies on, or the corner point it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from planner.borders import border_kernels, box_tree_kernels, generator_kernels, inside_kernels
from planner.borders.border_arrays import Corners, Pieces, Tree
from planner.borders.inside_kernels import ClosedBorders
from planner.scene import FloatArray, IntArray, Primitives
from planner.shared.arguments import as_positive

Mode: TypeAlias = Literal["exact", "paper"]
BoolArray: TypeAlias = NDArray[np.bool_]

SPACING_PER_RADIUS = 1.0
"""The default spacing in robot radii: half of what the method allows."""
BYTES_EACH = 600
"""Memory of the diagram for a generator: 530 bytes with 600,000 of them."""
MOST_MEMORY_BYTES = 4e9
"""Most memory of a diagram."""
JOINT = 1e-6
"""Distance of ends that are one joint, as a share of the scene's extent."""
NO_LENGTH = 1e-13
"""Length of edges that are points, as a share of the scene's extent."""
SAME_PLACE = 1e-9
"""Distance that counts as none, as a share of the scene's extent."""
EQUAL_DISTANCES = 1e-12
"""Difference of equal distances, as a share of the scene's extent, besides
``UNITS_IN_LAST_PLACE``."""
UNITS_IN_LAST_PLACE = 4.0
"""Units in the last place of the largest coordinate by which equal distances may differ, far from
the origin."""


class HasPrimitives(Protocol):
    """A scene, or any other source of borders."""

    def primitives(self) -> Primitives:
        """Return all borders as flat arrays, the bounds (owner -1) included."""
        ...


@dataclass(frozen=True, slots=True)
class Borders:
    """All borders as pieces, how they join, and a box tree that finds the nearest.

    ``pieces`` are the k primitives and then the c corner points; ``corners`` is their part for the
    diagram's kernels; ``tree`` is for :mod:`planner.borders.box_tree_kernels`. ``object_boxes`` (o,
    4) and ``span`` (o, 2) are every object's box and range of primitives; ``closed`` finds the
    objects around a place. ``box`` is x_min, y_min, x_max, y_max of the free space, and ``extent``
    its larger side. Places up to ``equal`` apart are equal.
    """

    pieces: Pieces
    corners: Corners
    tree: Tree
    object_boxes: FloatArray
    span: IntArray
    closed: ClosedBorders
    box: FloatArray
    extent: float
    equal: float

    @property
    def kind(self) -> NDArray[np.int8]:
        """(k + c,) kind of every piece."""
        return self.pieces.kind

    @property
    def data(self) -> FloatArray:
        """(k + c, 9) geometry of every piece."""
        return self.pieces.data

    @property
    def owner(self) -> IntArray:
        """(k + c,) object of every piece, -1 for the bounds."""
        return self.pieces.owner

    @property
    def primitive_count(self) -> int:
        """Number of primitives among the pieces; the rest are corner points."""
        return len(self.pieces.solid)

    def distances(self, points: FloatArray) -> tuple[FloatArray, IntArray]:
        """Exact distance of points (n, 2) to the nearest primitive, and that primitive."""
        return box_tree_kernels.nearest_many(self.tree, points)  # type: ignore[no-any-return]

    def signed_distances(self, points: FloatArray) -> FloatArray:
        """Distances as :meth:`distances`, negative in an obstacle and out of the bounds."""
        return inside_kernels.signed_distances(  # type: ignore[no-any-return]
            self.tree, self.closed, self.box, points
        )

    def is_solid(self, x: float, y: float, reach: float) -> bool:
        """True if (x, y), ``reach`` away from every border, lies in an object."""
        return bool(inside_kernels.in_object(self.kind, self.data, self.closed, x, y, reach))

    def owners_around(self, x: float, y: float, reach: float) -> NDArray[np.bool_]:
        """Mark the objects that contain (x, y), by even-odd; ``reach`` is its clearance."""
        count = int(self.owner.max(initial=-1)) + 1
        votes = inside_kernels.vote(self.kind, self.data, self.closed, x, y, reach, count)
        return votes >= inside_kernels.RAYS_THAT_DECIDE  # type: ignore[no-any-return]


@dataclass(frozen=True, slots=True)
class Generators:
    """``sites`` (n, 2) and the piece ``label`` (n,) of each, at most ``spacing`` apart."""

    sites: FloatArray
    label: IntArray
    spacing: float
    borders: Borders

    @property
    def owner(self) -> IntArray:
        """(n,) object of every generator, -1 for the bounds."""
        return self.borders.owner[self.label]


def choose_spacing(radius: float, spacing: float | None) -> float:
    """Given spacing, checked, or one radius by default."""
    if spacing is None:
        return SPACING_PER_RADIUS * radius
    value = as_positive("spacing", spacing)
    if value >= 2.0 * radius:
        raise ValueError(f"spacing = {spacing:g}: must be < 2 radius = {2.0 * radius:g}")
    return value


def gather_borders(scene: HasPrimitives, mode: Mode = "exact") -> Borders:
    """Scene's borders as pieces, joined and indexed. O(k log k)."""
    flat = scene.primitives()
    box = _free_box(flat)
    extent = extent_of(box)
    # a scene's arrays are read-only: numba would compile the kernels again
    kind, data, owner, border, is_hole, backwards = (
        np.array(array)
        for array in (flat.kind, flat.data, flat.owner, flat.border, flat.is_hole, flat.reversed)
    )
    pieces = border_kernels.join_primitives(
        kind, data, owner, border, is_hole, backwards, NO_LENGTH * extent, JOINT * extent,
        mode == "paper",
    )  # fmt: skip
    return as_borders(pieces, border_kernels.find_pieces(pieces), box, extent, _equal(box))


def as_borders(
    pieces: Pieces, found: tuple[Any, ...], box: FloatArray, extent: float, equal: float
) -> Borders:
    """Combine joined pieces and their indices, see :mod:`planner.borders.border_kernels`."""
    p = pieces
    corners = Corners(p.kind, p.data, p.owner, p.before, p.after)
    tree, object_boxes, span, closed = found
    return Borders(pieces, corners, tree, object_boxes, span, closed, box, extent, equal)


def extent_of(box: FloatArray) -> float:
    """Larger side of a box."""
    x0, y0, x1, y1 = box.tolist()
    return float(max(x1 - x0, y1 - y0))


def _equal(box: FloatArray) -> float:
    """Largest distance between equal places in a scene of this box."""
    return max(
        EQUAL_DISTANCES * extent_of(box),
        UNITS_IN_LAST_PLACE * math.ulp(max(map(abs, box.tolist()))),
    )


def _free_box(flat: Primitives) -> FloatArray:
    """Rectangle of the walls, or else all borders' box grown by its diagonal."""
    walls = border_kernels.walls_box(flat.data, flat.owner)
    if walls[0] <= walls[2]:
        return np.array(walls)
    if not len(flat.kind):
        raise ValueError("the scene has neither objects nor bounds")
    boxes, _ = box_tree_kernels.object_spans(flat.kind, flat.data, flat.owner, len(flat.kind))
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    grow = max(1.0, float(np.hypot(*(high - low))))
    return np.concatenate([low - grow, high + grow])


def count_generators(borders: Borders, spacing: float) -> float:
    """Upper bound of the generators that :func:`place_generators` makes.

    Infinite if too many to count, NaN if a place is not finite.
    """
    k, pieces = borders.primitive_count, borders.pieces
    most = generator_kernels.count_generators(
        pieces.kind[:k], pieces.data[:k], pieces.backwards, disc_around(borders, spacing), spacing
    )
    return float(most)


def disc_around(borders: Borders, spacing: float) -> tuple[float, float, float]:
    """Disc (x, y, radius) around the bounds that has generators."""
    x0, y0, x1, y1 = borders.box.tolist()
    width, height = x1 - x0, y1 - y0
    reach = 0.5 * math.sqrt(width * width + height * height) + generator_kernels.AROUND * spacing
    return x0 + 0.5 * width, y0 + 0.5 * height, reach


def place_generators(borders: Borders, spacing: float) -> Generators:
    """Place generators at most ``spacing`` apart on every border in the disc around the bounds.

    Raises ``ValueError`` beyond ``MOST_MEMORY_BYTES`` of memory.
    """
    k, pieces = borders.primitive_count, borders.pieces
    count = count_generators(borders, spacing)
    if math.isnan(count):
        raise ValueError("a border has a place that is not a finite number")
    if count * BYTES_EACH > MOST_MEMORY_BYTES:
        raise ValueError(
            f"spacing = {spacing:g}: the borders would take {count:.3g} generators and"
            f" {count * BYTES_EACH / 1e9:.3g} GB of memory: must be at most"
            f" {MOST_MEMORY_BYTES / 1e9:g} GB; take a larger spacing or radius"
        )
    sites, label = generator_kernels.place_generators(
        pieces.kind[:k],
        pieces.data[:k],
        pieces.backwards,
        pieces.data[k:, :2],
        pieces.before,
        pieces.after,
        disc_around(borders, spacing),
        spacing,
        int(count) + len(pieces.before),
    )
    return Generators(sites, label, spacing, borders)
