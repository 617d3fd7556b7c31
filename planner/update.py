"""A roadmap for a scene that differs from the last one by a few objects, without a rebuild.

Rules and units
- Objects that are the same in both scenes, wherever they stand in the list, keep their
  generators and whatever of the diagram nothing new comes near. The others' generators are
  taken out or put in, and the diagram is solved there only.
- The answer is the one that building anew gives, up to the order of nodes and edges and to
  where the polylines of the edges have their points. Where the bounds change, or most of the
  objects, it is built anew.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from planner import agvd_kernels, insertion_kernels, removal_kernels, update_kernels
from planner.agvd import Agvd, mesh_chains
from planner.generators import Borders, borders_of
from planner.mesh import Mesh, add_sites, copy_mesh
from planner.roadmap import Roadmap, build_roadmap, finish_roadmap
from planner.scene import FloatArray, IntArray, Primitives, Scene, SceneObject

MOST = 0.34
"""More changed objects than this share are a scene to be built anew."""


def update_roadmap(roadmap: Roadmap, scene: Scene) -> Roadmap:
    """The roadmap of ``scene`` with the radius, spacing and mode of ``roadmap``.

    Finds by itself which objects came, went or moved; ``roadmap`` itself does not change.
    O(n) copies and scans for n generators, and the work of building for what changed.
    """
    old_scene = roadmap.scene
    mesh = roadmap.agvd.mesh
    if mesh is None or not isinstance(old_scene, Scene) or old_scene.bounds != scene.bounds:
        return _anew(roadmap, scene)
    kept = match_objects(old_scene.objects, scene.objects)
    came = np.flatnonzero(kept < 0)
    stays = np.zeros(len(old_scene.objects), np.bool_)
    stays[kept[kept >= 0]] = True
    went = np.flatnonzero(~stays)
    if len(came) + len(went) > MOST * (len(scene.objects) + len(old_scene.objects)):
        return _anew(roadmap, scene)
    old = roadmap.borders
    if not (all(o.records for o in scene.objects) and len(old.span) == len(old_scene.objects)):
        return _anew(roadmap, scene)
    borders = _gather(old, scene, kept)
    new_label = _relabelled(old, borders, kept)
    if borders.extent != old.extent or new_label is None:
        return _anew(roadmap, scene)
    mesh = copy_mesh(mesh)
    touched = np.concatenate([old.object_boxes[went], borders.object_boxes[came]])
    update_kernels.forget_touched(
        touched, mesh.at, mesh.place, mesh.rho, mesh.state, mesh.seen, mesh.stale,
        mesh.traced.first, mesh.traced.link, mesh.bent.points, mesh.bent.start,
    )  # fmt: skip
    if not _change_sites(mesh, borders, new_label, came, roadmap.spacing):
        return _anew(roadmap, scene)
    mesh.bent = replace(mesh.bent, pieces=new_label[mesh.bent.pieces])
    agvd = Agvd(borders, roadmap.spacing, mesh)
    chains = mesh_chains(mesh, borders, roadmap.spacing)
    return finish_roadmap(scene, roadmap.radius, "exact", agvd, chains)


def _anew(roadmap: Roadmap, scene: Scene) -> Roadmap:
    return build_roadmap(scene, roadmap.radius, spacing=roadmap.spacing, mode=roadmap.mode)


def match_objects(old: Sequence[SceneObject], new: Sequence[SceneObject]) -> NDArray[np.int64]:
    """(n,) which old object every new one is, -1 where it is none; each old one once at most."""
    # most are the very same objects, or share their records
    same = dict(zip(map(id, old), range(len(old)), strict=True))
    kept = np.array([same.pop(key, -1) for key in map(id, new)], np.int64)
    left = set(range(len(old))).difference(kept.tolist())
    unknown = np.flatnonzero(kept < 0)
    if len(left) and len(unknown):
        shared = {id(old[i].records): i for i in left}
        for k in unknown.tolist():
            i = shared.get(id(new[k].records), -1)
            if i in left and old[i].holes == new[k].holes:
                kept[k] = i
                left.discard(i)
        unknown = unknown[kept[unknown] < 0]
    if len(left) and len(unknown):
        equal: dict[Hashable, list[int]] = {}
        for i in left:
            equal.setdefault((old[i].records, old[i].holes), []).append(i)
        for k in unknown.tolist():
            waiting = equal.get((new[k].records, new[k].holes))
            if waiting:
                kept[k] = waiting.pop()
    return kept


def _gather(old: Borders, scene: Scene, kept: NDArray[np.int64]) -> Borders:
    """The new scene's borders; the kept objects' primitives are copied from the old ones."""
    came = np.flatnonzero(kept < 0)
    fresh = replace(scene, objects=tuple(scene.objects[j] for j in came)).primitives(
        include_bounds=False
    )
    flat = old.flat
    arrays = update_kernels.gather_kept(
        kept, len(old.span), flat.kind, flat.data, flat.owner, flat.border, flat.is_hole,
        flat.reversed, fresh.kind, fresh.data, fresh.owner, fresh.border, fresh.is_hole,
        fresh.reversed,
    )  # fmt: skip
    for array in arrays:
        array.setflags(write=False)  # as a scene's: kernels are compiled for either kind
    return borders_of(Primitives(*arrays))


def _relabelled(old: Borders, new: Borders, kept: NDArray[np.int64]) -> IntArray | None:
    """Where the pieces of the kept objects and of the bounds are now; -1 for all others.

    The last entry is -1, for pieces that are none. None where they do not correspond.
    """
    label, fits = update_kernels.relabel(
        kept, len(old.span), old.owner, old.primitive_count, new.owner, new.primitive_count
    )
    return label if fits else None


def _change_sites(
    mesh: Mesh, borders: Borders, new_label: IntArray, came: NDArray[np.int64], spacing: float
) -> bool:
    """Take out the sites of pieces that are no more and put in those of the new objects."""
    gone, quiet, heirs = update_kernels.unlink_sites(
        mesh.label, new_label, mesh.alias, mesh.also, mesh.used
    )
    if len(gone) and not removal_kernels.remove(mesh.xy, mesh.ghost, mesh.tri, mesh.circ, gone):
        return False
    mesh.vacant += [*gone.tolist(), *quiet.tolist()]
    if len(heirs):
        w, nowhere = np.empty(insertion_kernels.SCRATCH), np.empty(0, np.int64)
        insertion_kernels.insert(
            w, mesh.xy, mesh.ghost, mesh.tri, mesh.circ, mesh.alias, heirs, nowhere
        )
    for o in came:
        places, labels = _generators_of_object(borders, int(o), spacing)
        if len(places) and np.abs(places).max() > mesh.up:
            return False
        add_sites(mesh, places, labels, np.full(len(places), -1, np.int64))
    return True


def _generators_of_object(
    borders: Borders, owner: int, spacing: float
) -> tuple[FloatArray, IntArray]:
    """The generators of one object, and the pieces that they are on."""
    k = borders.primitive_count
    lo, hi = borders.span[owner].tolist()
    c_lo, c_hi, before, after = update_kernels.corners_of(
        owner, borders.owner, k, borders.before, borders.after, lo
    )
    kind, data = borders.kind[lo:hi], borders.data[lo:hi]
    room = int(agvd_kernels.count_generators(kind, data, spacing)) + len(before)
    at = borders.data[k + c_lo : k + c_hi, :2]
    places, label = agvd_kernels.place_generators(
        kind, data, borders.backwards[lo:hi], at, before, after, spacing, room
    )
    n = hi - lo
    return places, np.where(label < n, label + lo, label - n + k + c_lo).astype(np.int32)
