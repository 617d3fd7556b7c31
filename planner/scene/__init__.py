"""The scene: the free space's boundary, the objects in it, and operations on their borders.

- ``records.py`` defines the paper's records, ``scene.py`` the scene, ``unknown_cells.py`` its
  unseen cells; ``polygons.py`` converts polygons and GeoJSON, ``drawing.py`` draws.
- ``flat_arcs.py`` flattens a scene to the arrays of ``primitives.py``.
- ``primitive_kernels.py`` and ``shape_kernels.py`` compute on these; ``compile_options.py`` holds
  the kernels' options.

Other packages import from here, kernels from :mod:`planner.scene.primitive_kernels`.
"""

from planner.scene.flat_arcs import flatten
from planner.scene.primitives import (
    ARC,
    CIRCLE,
    POINT,
    SEGMENT,
    FloatArray,
    IntArray,
    Primitives,
)
from planner.scene.records import (
    Arc,
    ArcRecord,
    CircleRecord,
    Edge,
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
    printable,
    record_edges,
)
from planner.scene.scene import (
    Binarisation,
    Bounds,
    Scene,
    Units,
    derived_bounds,
)
from planner.scene.unknown_cells import UnknownCells
from planner.shared.arguments import of_kind

__all__ = [
    "ARC",
    "CIRCLE",
    "POINT",
    "SEGMENT",
    "Arc",
    "ArcRecord",
    "Binarisation",
    "Bounds",
    "CircleRecord",
    "Edge",
    "FloatArray",
    "IntArray",
    "PointRecord",
    "PolygonRecord",
    "Primitives",
    "Record",
    "Scene",
    "SceneError",
    "SceneObject",
    "Segment",
    "SegmentRecord",
    "Units",
    "UnknownCells",
    "Vec",
    "derived_bounds",
    "extent_points",
    "flatten",
    "object_records",
    "of_kind",
    "printable",
    "record_edges",
]
