"""Diagram of a scene that differs from the last one by a few objects, without a rebuild.

Rules and units
- Objects in both scenes keep their generators and the diagram that nothing new comes near;
  elsewhere generators are removed or added, and the diagram is solved.
- The result equals that of a build from scratch, up to the order of nodes and edges and the points
  of the edges' polylines.
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
    MOST_MEMORY_BYTES,
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

MOST_CHANGED = 0.34
"""Share of changed objects from which a scene is built from scratch."""


def update_diagram(agvd: Agvd, old: Scene, scene: Scene) -> Agvd | None:
    """Diagram of ``scene`` from that of ``old``; None if it must be built from scratch.

    ``agvd`` itself does not change. O(n) copies and scans for n generators, and the work of
    building for the changes.
    """
    mesh = agvd.mesh
    if mesh is None or old.bounds != scene.bounds:
        return None
    kept = match_objects(old.objects, scene.objects)
    came = [j for j, i in enumerate(kept) if i < 0]
    went = len(old.objects) - len(kept) + len(came)
    if len(came) + went > MOST_CHANGED * (len(scene.objects) + len(old.objects)):
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
    """Old object of every new one, or -1; each is used at most once."""
    # most share their records with an old object at the same place, or shifted by one
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
    """Key that hardly any unequal objects share: hashing all edges takes long."""
    record = item.records[0] if item.records else None
    if isinstance(record, ArcRecord | PolygonRecord) and record.edges:
        return record.edges[0]
    return record


def _first_other(old: Sequence[SceneObject], new: Sequence[SceneObject]) -> int:
    n = 0
    for a, b in zip(old, new, strict=False):
        if a is not b and not (a.records is b.records and a.holes is b.holes):
            break
        n += 1
    return n


def _flatten(scene: Scene, came: list[int]) -> NewBorders:
    """Borders of the new objects ``came``."""
    flat = flatten([scene.objects[j] for j in came], scene.view, scene.y_down)
    return NewBorders(
        np.array(flat.kind, np.int8), np.array(flat.numbers, np.float64).reshape(-1, 6),
        np.array(flat.turned, np.int32), np.array(flat.borders, np.int32).reshape(-1, 3),
    )  # fmt: skip


def _fits_memory(agvd: Agvd, new: NewBorders) -> bool:
    backwards, disc = np.zeros(len(new.kind), np.bool_), disc_around(agvd.borders, agvd.spacing)
    backwards[new.turned] = True
    most = count_generators(new.kind, new.rows, backwards, disc, agvd.spacing)
    return bool(most * BYTES_EACH <= MOST_MEMORY_BYTES)


def _change_borders(
    agvd: Agvd, old_objects: int, kept: list[int], new: NewBorders
) -> tuple[Borders, IntArray, FloatArray, IntArray, FloatArray]:
    old = agvd.borders
    pieces, found, *rest = border_kernels.change_borders(
        np.array(kept, np.int64), old_objects, old.pieces, old.object_boxes, new,
        NO_LENGTH * old.extent, JOINT * old.extent, disc_around(old, agvd.spacing), agvd.spacing,
    )  # fmt: skip
    new_label, places, labels, touched = rest
    borders = as_borders(pieces, found, old.box, old.extent, old.equal)
    return borders, new_label, places, labels, touched


def _take_out(mesh: Mesh, new_label: IntArray, touched: FloatArray) -> bool:
    """Remove the sites of removed pieces; False if that spoils the mesh."""
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
