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
    went = np.setdiff1d(np.arange(len(old_scene.objects)), kept)
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
        mesh.bent[0], mesh.bent[1], mesh.bent[2], mesh.bent[4],
    )  # fmt: skip
    if not _change_sites(mesh, borders, new_label, came, roadmap.spacing):
        return _anew(roadmap, scene)
    first, link, out, pair, start, proved = mesh.bent
    mesh.bent = first, link, out, new_label[pair], start, proved
    agvd = Agvd(borders, roadmap.spacing, mesh)
    chains = mesh_chains(mesh, borders, roadmap.spacing)
    return finish_roadmap(scene, roadmap.radius, "exact", agvd, chains)


def _anew(roadmap: Roadmap, scene: Scene) -> Roadmap:
    return build_roadmap(scene, roadmap.radius, spacing=roadmap.spacing, mode=roadmap.mode)


def match_objects(old: Sequence[SceneObject], new: Sequence[SceneObject]) -> NDArray[np.int64]:
    """(n,) which old object every new one is, -1 where it is none; each old one once at most."""
    same = {id(o.records): i for i, o in enumerate(old)}
    kept = np.full(len(new), -1, np.int64)
    left = set(range(len(old)))
    for j, o in enumerate(new):
        i = same.get(id(o.records), -1)
        if i in left and old[i].holes == o.holes:
            kept[j] = i
            left.discard(i)
    if len(left) and (kept < 0).any():
        equal: dict[Hashable, list[int]] = {}
        for i in left:
            equal.setdefault((old[i].records, old[i].holes), []).append(i)
        for k in np.flatnonzero(kept < 0).tolist():
            waiting = equal.get((new[k].records, new[k].holes))
            if waiting:
                kept[k] = waiting.pop()
    return kept


def _gather(old: Borders, scene: Scene, kept: NDArray[np.int64]) -> Borders:
    """The new scene's borders; the kept objects' primitives are copied from the old ones."""
    count = len(kept)
    came = np.flatnonzero(kept < 0)
    fresh = replace(scene, objects=tuple(scene.objects[j] for j in came))
    parts = old.flat, fresh.primitives(include_bounds=False)
    old_first, old_count = _ranges(old.flat.owner, len(old.span))
    new_first, new_count = _ranges(parts[1].owner, len(came))
    here = kept >= 0
    first, size = np.empty(count + 1, np.int64), np.empty(count + 1, np.int64)
    first[:-1][here], size[:-1][here] = old_first[kept[here]], old_count[kept[here]]
    first[came], size[came] = len(old.flat.kind) + new_first[:-1], new_count[:-1]
    first[-1], size[-1] = old_first[-1], old_count[-1]
    rows = _spread(first, size)
    owner = np.repeat([*range(count), -1], size).astype(np.int32)
    most = int(old.flat.border.max(initial=0)) + 1
    border = np.concatenate([old.flat.border, parts[1].border + np.int32(most)])[rows]
    kind, data, is_hole, backwards = (
        np.concatenate([getattr(part, name) for part in parts])[rows]
        for name in ("kind", "data", "is_hole", "reversed")
    )
    return borders_of(Primitives(kind, data, owner, border, is_hole, backwards))


def _spread(first: NDArray[np.int64], size: NDArray[np.int64]) -> NDArray[np.int64]:
    """The ranges that begin at ``first`` and are ``size`` long, one after the other."""
    return np.repeat(first - np.cumsum(size) + size, size) + np.arange(size.sum())


def _relabelled(old: Borders, new: Borders, kept: NDArray[np.int64]) -> IntArray | None:
    """Where the pieces of the kept objects and of the bounds are now; -1 for all others.

    The last entry is -1, for pieces that are none. None where they do not correspond.
    """
    label = np.full(len(old.kind) + 1, -1, np.int32)
    k, m = old.primitive_count, new.primitive_count
    here = np.append(np.flatnonzero(kept >= 0), len(kept))
    there = np.append(kept[kept >= 0], len(old.span))
    for start, stop, offset, end in ((0, k, 0, m), (k, len(old.kind), m, len(new.kind))):
        old_first, old_count = _ranges(old.owner[start:stop], len(old.span))
        new_first, new_count = _ranges(new.owner[offset:end], len(kept))
        size = old_count[there]
        if (size != new_count[here]).any():
            return None
        label[start + _spread(old_first[there], size)] = offset + _spread(new_first[here], size)
    return label


def _ranges(owner: IntArray, objects: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First index and count of every object's pieces; the last ones are the bounds'."""
    who = np.where(owner < 0, objects, owner)
    count = np.bincount(who, minlength=objects + 1)
    return np.cumsum(count) - count, count


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
    lo, hi = (int(v) for v in borders.span[owner])
    corners = np.flatnonzero(borders.owner[k:] == owner)
    if not len(corners):
        corners = np.zeros(0, np.int64)
    c_lo, c_hi = (int(corners[0]), int(corners[-1]) + 1) if len(corners) else (0, 0)
    before, after = (
        np.where(a[c_lo:c_hi] >= 0, a[c_lo:c_hi] - lo, -1).astype(np.int32)
        for a in (borders.before, borders.after)
    )
    kind, data = borders.kind[lo:hi], borders.data[lo:hi]
    room = int(agvd_kernels.count_generators(kind, data, spacing)) + len(before)
    at = borders.data[k + c_lo : k + c_hi, :2]
    places, label = agvd_kernels.place_generators(
        kind, data, borders.backwards[lo:hi], at, before, after, spacing, room
    )
    n = hi - lo
    return places, np.where(label < n, label + lo, label - n + k + c_lo).astype(np.int32)
