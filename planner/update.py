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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from planner import agvd_kernels, border_kernels, insertion_kernels, removal_kernels, update_kernels
from planner.agvd import Agvd, mesh_chains
from planner.generators import index_borders, join_primitives
from planner.mesh import Mesh, add_sites, copy_mesh
from planner.roadmap import Roadmap, build_roadmap, finish_roadmap
from planner.scene import FloatArray, IntArray, Scene, SceneObject

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
    went = np.ones(len(old_scene.objects), np.bool_)
    went[kept[kept >= 0]] = False
    if len(came) + went.sum() > MOST * (len(scene.objects) + len(old_scene.objects)):
        return _anew(roadmap, scene)
    old = roadmap.borders
    some = replace(scene, objects=tuple(scene.objects[j] for j in came.tolist()))
    fresh = join_primitives(some.primitives(include_bounds=False), old.box)
    pieces, new_label, fresh_label = border_kernels.patch_borders(
        kept, len(old_scene.objects), old.pieces, len(came), fresh
    )
    borders = index_borders(pieces, old.box)
    mesh = copy_mesh(mesh)
    # the last objects have no boxes where they have no pieces
    there = went[: len(old.span)], came[came < len(borders.span)]
    touched = np.concatenate([old.object_boxes[there[0]], borders.object_boxes[there[1]]])
    update_kernels.forget_touched(
        touched, mesh.at, mesh.place, mesh.rho, mesh.state, mesh.seen, mesh.stale,
        mesh.traced.first, mesh.traced.link, mesh.bent.points, mesh.bent.start,
    )  # fmt: skip
    places, labels = _generators_of(fresh, roadmap.spacing)
    if not _change_sites(mesh, new_label, places, fresh_label[labels]):
        return _anew(roadmap, scene)
    mesh.bent = replace(mesh.bent, pieces=new_label[mesh.bent.pieces])
    agvd = Agvd(borders, roadmap.spacing, mesh)
    chains = mesh_chains(mesh, borders, roadmap.spacing)
    return finish_roadmap(scene, roadmap.radius, "exact", agvd, chains)


def _anew(roadmap: Roadmap, scene: Scene) -> Roadmap:
    return build_roadmap(scene, roadmap.radius, spacing=roadmap.spacing, mode=roadmap.mode)


def match_objects(old: Sequence[SceneObject], new: Sequence[SceneObject]) -> NDArray[np.int64]:
    """(n,) which old object every new one is, -1 where it is none; each old one once at most."""
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
        equal: dict[Hashable, list[int]] = {}
        for i in left:
            equal.setdefault((old[i].records, old[i].holes), []).append(i)
        for k in unknown:
            waiting = equal.get((new[k].records, new[k].holes))
            if waiting:
                kept[k] = waiting.pop()
    return np.array(kept, np.int64)


def _first_other(old: Sequence[SceneObject], new: Sequence[SceneObject]) -> int:
    """How many objects at the beginning of both share their records, and have no holes."""
    n = 0
    for a, b in zip(old, new, strict=False):
        if a is not b and not (a.records is b.records and a.holes is b.holes):
            break
        n += 1
    return n


def _change_sites(mesh: Mesh, new_label: IntArray, places: FloatArray, labels: IntArray) -> bool:
    """Take out the sites of pieces that are no more and put in those at the ``places``."""
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
    if len(places):
        if np.abs(places).max() > mesh.up:
            return False
        add_sites(mesh, places, labels, np.full(len(places), -1, np.int64))
    return True


def _generators_of(pieces: tuple[Any, ...], spacing: float) -> tuple[FloatArray, IntArray]:
    """The generators of the new objects' pieces, and which of these each is on."""
    kind, data, _, backwards, _, _, _, before, after = pieces
    k = len(backwards)
    kind, at, data = kind[:k], data[k:, :2], data[:k]
    room = int(agvd_kernels.count_generators(kind, data, spacing)) + len(before)
    places, label = agvd_kernels.place_generators(
        kind, data, backwards, at, before, after, spacing, room
    )
    return places, label
