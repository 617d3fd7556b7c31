"""The scene: the free space's boundary and the objects in it, as the paper's records.

Rules and units
- A scene has its own units: ``px`` (a picture, y down, pixel centres at integers), ``m`` (a
  calibrated arena, y up) or ``cells`` (a grid map without a size, y down).
- Records, edges and their sense of turning are those of ``records.py``.
- An object is one connected obstacle: its outline's records and, for each hole, the records of the
  hole's border. The solid is between them; a hole is free space.
- Everything here is immutable; arrays are read-only.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

from numpy.typing import ArrayLike

from planner.scene.drawing import StyledLines, View, obstacle_layers, plot, to_svg, wall_layer
from planner.scene.flat_arcs import flatten
from planner.scene.polygons import geo_of, objects_from_geo, objects_from_polygons
from planner.scene.primitives import Primitives
from planner.scene.records import (
    ArcRecord,
    CircleRecord,
    PointRecord,
    PolygonRecord,
    Record,
    SceneError,
    SceneObject,
    Segment,
    SegmentRecord,
    Vec,
    extent_points,
    object_records,
)
from planner.scene.specks import without_small
from planner.scene.unknown_cells import UnknownCells
from planner.shared.arguments import as_float, as_index, as_list, as_numbers, of_kind

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RECORDS = PointRecord, SegmentRecord, CircleRecord, ArcRecord, PolygonRecord
Units: TypeAlias = Literal["px", "m", "cells"]
GEO_TOLERANCE = 1e-4
"""By how much chords leave their arcs in ``__geo_interface__``, as a share of the bounds."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """Rectangle that holds the free space; its sides are walls."""

    x_min: float
    y_min: float
    x_max: float
    y_max: float

    @property
    def ranges(self) -> str:
        """Text for messages: ``x 0..4, y 0..3``."""
        return f"x {self.x_min:g}..{self.x_max:g}, y {self.y_min:g}..{self.y_max:g}"

    @property
    def width(self) -> float:
        """Extent along x."""
        return self.x_max - self.x_min

    @property
    def height(self) -> float:
        """Extent along y."""
        return self.y_max - self.y_min

    def contains(self, point: Vec) -> bool:
        """True if the point lies inside or on the rectangle."""
        return self.x_min <= point[0] <= self.x_max and self.y_min <= point[1] <= self.y_max

    def corners(self) -> tuple[Vec, Vec, Vec, Vec]:
        """Four corners, in the order of growing angle (x right, y along the axis)."""
        return (
            (self.x_min, self.y_min),
            (self.x_max, self.y_min),
            (self.x_max, self.y_max),
            (self.x_min, self.y_max),
        )


def derived_bounds(points: Iterable[Vec]) -> Bounds:
    """Generous rectangle: the bounding box of ``points``, grown by its diagonal (at least 1)."""
    xs, ys = zip(*points, strict=True)
    grow = max(1.0, math.dist((min(xs), min(ys)), (max(xs), max(ys))))
    return Bounds(min(xs) - grow, min(ys) - grow, max(xs) + grow, max(ys) + grow)


@dataclass(frozen=True, slots=True)
class Binarisation:
    """Method by which a picture was made black and white, and the reason."""

    method: str
    threshold: float
    polarity: Literal["dark", "light"]
    reason: str


@dataclass(frozen=True, slots=True)
class Scene:
    """The free space's boundary and the objects, with facts learned while seeing them.

    ``bounds_given`` is False if the source had no bounds and a generous rectangle was derived.
    ``size`` is the picture's (width, height) in pixels, or the grid's in cells. ``border_pixels``
    is n of the paper; ``timings_ms`` holds the stages' wall times. ``remarks`` are plain sentences
    on what was degraded, dropped or found touching. ``unknown`` are a map's unseen cells; they do
    not count in comparisons of scenes.
    """

    units: Units
    bounds: Bounds
    objects: tuple[SceneObject, ...]
    bounds_given: bool = True
    size: tuple[int, int] | None = None
    border_pixels: int = 0
    binarisation: Binarisation | None = None
    timings_ms: Mapping[str, float] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    unknown: UnknownCells | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        b = of_kind("bounds", self.bounds, Bounds)
        _check_units(self.units)
        sides = zip(("x_min", "y_min", "x_max", "y_max"), self.view, strict=True)
        if not all(math.isfinite(as_float(f"bounds.{name}", v)) for name, v in sides):
            raise SceneError(f"bounds {b}: must be finite")
        if not (b.x_min < b.x_max and b.y_min < b.y_max):
            raise SceneError(f"bounds {b}: must have a positive width and height")
        of_kind("objects", self.objects, tuple, list)
        for number, one in enumerate(self.objects):
            if not isinstance(one, SceneObject):
                raise SceneError(
                    f"object {number} is a {type(one).__name__}: must be a SceneObject; "
                    "Scene.from_polygons makes them of arrays"
                )
            for border in (one.records, *one.holes):
                of_kind(f"the records of object {number}", border, tuple, list)
                for record in border:
                    if type(record) not in RECORDS:  # fast: there may be many
                        of_kind(f"a record of object {number}", record, *RECORDS)

    @classmethod
    def from_polygons(
        cls,
        polygons: Iterable[ArrayLike] = (),
        circles: Iterable[Sequence[float]] = (),
        *,
        bounds: Bounds | Sequence[float] | None = None,
        units: Units = "m",
    ) -> Scene:
        """Return the scene of obstacles that are polygons (n, 2) or circles (x, y, radius).

        Polygons may turn either way; overlapping ones stay two objects. Without ``bounds`` (x_min,
        y_min, x_max, y_max) a generous rectangle is derived. Raises :class:`SceneError` naming the
        unusable one: too few vertices, no area, sides that cross.
        """
        _check_units(units)
        rings, discs = as_list("polygons", polygons, "arrays"), as_list("circles", circles, "rows")
        objects = objects_from_polygons(rings, discs, y_down=units != "m")
        return cls._around(objects, bounds, units)

    @classmethod
    def from_geo(
        cls,
        geometry: object,
        *,
        bounds: Bounds | Sequence[float] | None = None,
        units: Units = "m",
    ) -> Scene:
        """Return the scene of an object with ``__geo_interface__``, or of a GeoJSON-like mapping.

        That is a geometry of shapely, a GeoSeries or GeoDataFrame of GeoPandas, or this scene's own
        ``__geo_interface__``: polygons with their holes, lines and points, also in collections.
        Bounds, units and errors are as in :meth:`from_polygons`.
        """
        _check_units(units)
        return cls._around(objects_from_geo(geometry, y_down=units != "m"), bounds, units)

    @classmethod
    def _around(
        cls,
        objects: tuple[SceneObject, ...],
        bounds: Bounds | Sequence[float] | None,
        units: Units,
    ) -> Scene:
        if isinstance(bounds, Bounds):
            return cls(units, bounds, objects)
        if bounds is not None:
            sides = tuple(
                as_numbers("bounds", bounds, "x_min, y_min, x_max, y_max").ravel().tolist()
            )
            if len(sides) != 4:
                raise SceneError(f"bounds {sides}: must be x_min, y_min, x_max, y_max")
            return cls(units, Bounds(*sides), objects)
        if not objects:
            raise SceneError("no obstacle and no bounds: one of them must be given")
        points = (point for one in objects for point in extent_points(one))
        return cls(units, derived_bounds(points), objects, bounds_given=False)

    @property
    def __geo_interface__(self) -> dict[str, Any]:
        """The objects as a GeoJSON-like feature collection, for shapely, GeoPandas and others.

        Arcs are chords within 1/10,000 of the bounds' longer side; :meth:`to_geo` takes another
        tolerance.
        """
        return self.to_geo(GEO_TOLERANCE * max(self.bounds.width, self.bounds.height))

    def to_geo(self, tolerance: float) -> dict[str, Any]:
        """Return the same with chords within ``tolerance`` (> 0) of their arcs."""
        least = as_float("tolerance", tolerance)
        if not least > 0.0:
            raise SceneError(f"tolerance {least}: must be > 0")
        return geo_of(self.objects, least, y_down=self.y_down)

    def __repr__(self) -> str:
        """Return one line; ``objects`` has the rest."""
        b, count = self.bounds, len(self.objects)
        objects = "1 object" if count == 1 else f"{count} objects"
        return f"<Scene of {objects}, {b.width:.6g} x {b.height:.6g} {self.units}>"

    @property
    def y_down(self) -> bool:
        """True if y grows downwards on the screen (pictures and grid maps)."""
        return self.units != "m"

    @property
    def vertex_count(self) -> int:
        """m of the paper: the number of points and circles that the records store."""
        return sum(_stored_points(r) for o in self.objects for r in object_records(o))

    def with_bounds(self, bounds: Bounds) -> Scene:
        """Return the same objects inside other bounds."""
        return replace(self, bounds=bounds, bounds_given=True)

    def replace_object(self, number: int, *others: SceneObject) -> Scene:
        """Return the scene with ``others`` in place of ``objects[number]``, or without it.

        ``IndexError`` if there is no such object. The others keep their order and ids.
        """
        count = len(self.objects)
        number = as_index("number", number)
        if not 0 <= number < count:
            raise IndexError(f"object {number}: the scene has {count}, numbered from 0")
        objects = (*self.objects[:number], *others, *self.objects[number + 1 :])
        return replace(self, objects=objects)

    def without_specks(self, least_area: float) -> Scene:
        """Return the scene without obstacles smaller than ``least_area``; a remark counts them.

        For maps and pictures in which single cells of noise reshape the roadmap. A path does not
        avoid what was left out: no run of a robot does this. Sizes are those of
        :mod:`planner.scene.specks`, in square units of the scene. ``SceneError`` unless
        ``least_area`` is a finite number > 0.
        """
        least = as_float("least_area", least_area)
        if not 0.0 < least < math.inf:
            raise SceneError(f"least_area = {least:g}: must be > 0 and finite")
        kept, sentence = without_small(self.objects, least, self.units, y_down=self.y_down)
        return replace(self, objects=kept, remarks=(*self.remarks, sentence))

    def layers(self) -> list[StyledLines]:
        """Layers to draw: each object's solid, open lines, and the bounds."""
        return [*obstacle_layers(self.objects, self.view, self.y_down), wall_layer(self.view)]

    @property
    def view(self) -> View:
        """Drawn rectangle: x_min, y_min, x_max, y_max."""
        b = self.bounds
        return b.x_min, b.y_min, b.x_max, b.y_max

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the scene on Matplotlib axes, by default the current ones; return the axes."""
        return plot(self.layers(), self.y_down, axes)

    def _repr_svg_(self) -> str:
        """Picture for a notebook."""
        return to_svg(
            f"a scene of {len(self.objects)} objects", self.layers(), self.view, self.y_down
        )

    def primitives(self, include_bounds: bool = True) -> Primitives:
        """All borders as flat arrays, in the order of the objects; the bounds come last.

        Circles and arcs of very large radius are chords there, see :mod:`planner.scene.flat_arcs`.
        """
        flat = flatten(self.objects, self.view, self.y_down)
        if include_bounds:
            c = self.bounds.corners()
            sides = tuple(Segment(c[i], c[(i + 1) % 4]) for i in range(4))
            flat.add_border((PolygonRecord(sides),), -1, is_hole=True)
        return flat.finish()


def _check_units(units: Any) -> None:
    if not isinstance(units, str) or units not in get_args(Units):
        raise SceneError(f"units {units!r}: must be one of {', '.join(get_args(Units))}")


def _stored_points(record: Record) -> int:
    match record:
        case SegmentRecord():
            return 2
        case ArcRecord(edges):
            return len(edges) + 1
        case PolygonRecord(edges):
            return len(edges)
        case _:
            return 1
