"""The diagram of a scene that differs from the last one by a few objects, without a rebuild.

Rules and units
- Objects that are the same in both scenes, wherever they stand in the list, keep their
  generators and whatever of the diagram nothing new comes near. The others' generators are
  taken out or put in, and the diagram is solved there only.
- The answer is the one that building from scratch gives, up to the order of nodes and edges and to
  where the polylines of the edges have their points. Where the bounds change, or most of the
  objects, it is built from scratch.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np

from planner.borders import border_kernels
from planner.borders.border_kernels import NewBorders
from planner.borders.generator_kernels import count_generators
from planner.borders.generators import (
    BYTES_EACH,
    JOINT,
    MOST_BYTES,
    NO_LENGTH,
    Borders,
    as_borders,
    disc_around,
)
from planner.delaunay import removal_kernels
from planner.diagram import update_kernels
from planner.diagram.agvd import Agvd
from planner.diagram.diagram_arrays import Bent
from planner.diagram.mesh import Mesh, add_sites, copy_mesh, insert
from planner.scene import (
    ArcRecord,
    FloatArray,
    IntArray,
    PolygonRecord,
    Scene,
    SceneObject,
    flatten,
)

MOST = 0.34
"""More changed objects than this share are a scene to be built from scratch."""


def update_diagram(agvd: Agvd, old: Scene, scene: Scene) -> Agvd | None:
    """The diagram of ``scene`` from that of ``old``; None where it is to be built from scratch.

    Finds by itself which objects came, went or moved; ``agvd`` itself does not change.
    O(n) copies and scans for n generators, and the work of building for what changed.
    """
    mesh = agvd.mesh
    if mesh is None or old.bounds != scene.bounds:
        return None
    kept = match_objects(old.objects, scene.objects)
    came = [j for j, i in enumerate(kept) if i < 0]
    went = len(old.objects) - len(kept) + len(came)
    if len(came) + went > MOST * (len(scene.objects) + len(old.objects)):
        return None
    new = _flatten(scene, came)
    if not _fits_memory(agvd, new):
        return None
    borders, new_label, places, labels, touched = _change_borders(agvd, len(old.objects), kept, new)
    mesh = copy_mesh(mesh)
    fits = not len(places) or float(abs(places).max()) <= mesh.up
    if not (fits and _take_out(mesh, new_label, touched)):
        return None
    if len(places):
        nowhere = np.full(len(places), -1, np.int64)
        add_sites(mesh, places, labels, nowhere, refined=False)
    return Agvd(borders, agvd.spacing, mesh)


def match_objects(old: Sequence[SceneObject], new: Sequence[SceneObject]) -> list[int]:
    """Which old object every new one is, -1 where it is none; each old one once at most."""
    # most share their records with those where they were, or moved up by one
    ahead = _first_other(old, new)
    behind = _first_other(old[ahead:][::-1], new[ahead:][::-1])
    kept = [*range(ahead), *[-1] * (len(new) - ahead - behind), *range(len(old) - behind, len(old))]
    left = set(range(ahead, len(old) - behind))
    unknown = list(range(ahead, len(new) - behind))
    if left and unknown:
        shared = {id(old[i].records): i for i in left}
        for k in unknown:
            i = shared.get(id(new[k].records), -1)
            if i in left and old[i].holes == new[k].holes:
                kept[k] = i
                left.discard(i)
        unknown = [k for k in unknown if kept[k] < 0]
    if left and unknown:
        alike: dict[Hashable, list[int]] = {}
        for i in left:
            alike.setdefault(_mark(old[i]), []).append(i)
        for k in unknown:
            candidates = alike.get(_mark(new[k]), [])
            for i in candidates:
                if old[i].records == new[k].records and old[i].holes == new[k].holes:
                    kept[k] = i
                    candidates.remove(i)
                    break
    return kept


def _mark(item: SceneObject) -> Hashable:
    """What equal objects share, and hardly any others: all their edges take long to hash."""
    record = item.records[0] if item.records else None
    if isinstance(record, ArcRecord | PolygonRecord) and record.edges:
        return record.edges[0]
    return record


def _first_other(old: Sequence[SceneObject], new: Sequence[SceneObject]) -> int:
    """How many objects at the beginning of both share their records, and have no holes."""
    n = 0
    for a, b in zip(old, new, strict=False):
        if a is not b and not (a.records is b.records and a.holes is b.holes):
            break
        n += 1
    return n


def _flatten(scene: Scene, came: list[int]) -> NewBorders:
    """The borders of the objects that ``came``."""
    flat = flatten([scene.objects[j] for j in came], scene.view, scene.y_down)
    return NewBorders(
        np.array(flat.kind, np.int8), np.array(flat.numbers, np.float64).reshape(-1, 6),
        np.array(flat.turned, np.int32), np.array(flat.borders, np.int32).reshape(-1, 3),
    )  # fmt: skip


def _fits_memory(agvd: Agvd, new: NewBorders) -> bool:
    """True if there is memory for the new borders' generators."""
    backwards, disc = np.zeros(len(new.kind), np.bool_), disc_around(agvd.borders, agvd.spacing)
    backwards[new.turned] = True
    most = count_generators(new.kind, new.rows, backwards, disc, agvd.spacing)
    return bool(most * BYTES_EACH <= MOST_BYTES)


def _change_borders(
    agvd: Agvd, old_objects: int, kept: list[int], new: NewBorders
) -> tuple[Borders, IntArray, FloatArray, IntArray, FloatArray]:
    """The scene's borders, and the rest of what :func:`border_kernels.change_borders` returns.

    The ``new`` borders are joined, the ``kept`` objects' pieces copied.
    """
    old = agvd.borders
    pieces, found, *rest = border_kernels.change_borders(
        np.array(kept, np.int64), old_objects, old.pieces, old.object_boxes, new,
        NO_LENGTH * old.extent, JOINT * old.extent, disc_around(old, agvd.spacing), agvd.spacing,
    )  # fmt: skip
    new_label, places, labels, touched = rest
    borders = as_borders(pieces, found, old.box, old.extent, old.equal)
    return borders, new_label, places, labels, touched


def _take_out(mesh: Mesh, new_label: IntArray, touched: FloatArray) -> bool:
    """Take out the sites of pieces that are no more; False where the mesh is spoiled by that."""
    traced, bent = mesh.traced, mesh.bent
    gone, quiet, heirs, pieces, proved = update_kernels.unlink(
        touched, new_label, mesh.sites, mesh.triangles, traced, bent
    )
    done = not len(gone) or removal_kernels.remove(mesh.xy, mesh.ghost, mesh.tri, mesh.circ, gone)
    mesh.bent = Bent(bent.points, pieces, bent.start, proved)
    mesh.vacant += [*gone.tolist(), *quiet.tolist()]
    if done and len(heirs):
        nowhere = np.empty(0, np.int64)
        insert(mesh, heirs, np.empty((0, 2)), np.empty(0, np.int32), nowhere)
    return bool(done)
