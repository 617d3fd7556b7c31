"""Parts of a solved mesh that a change of objects touches.

Rules and units
- Scene's units. A place is touched if the box of an added or removed object reaches into its
  circle, or lies around it.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.delaunay.triangle_kernels import DEAD
from planner.scene.compile_options import LEAF, OWNING

CIRCLE_EXCESS = 1e-9
"""Share by which circles count as larger."""


@njit(**LEAF)
def _reaches(boxes, b, x, y, r):
    """True if box b comes within r of (x, y)."""
    dx = max(boxes[b, 0] - x, 0.0, x - boxes[b, 2])
    dy = max(boxes[b, 1] - y, 0.0, y - boxes[b, 3])
    return dx * dx + dy * dy <= r * r * (1.0 + CIRCLE_EXCESS)


@njit(**LEAF)
def _mark_inside(boxes, at, inside):
    for b in range(len(boxes)):
        x0, y0, x1, y1 = boxes[b, 0], boxes[b, 1], boxes[b, 2], boxes[b, 3]
        for i in range(len(at)):
            # without branches: several places at once
            x, y = at[i, 0], at[i, 1]
            inside[i] |= (x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)


@njit(**LEAF)
def _forget_touched(boxes, triangles, inside, traced, bent, proved):
    """Mark everything in the ``boxes`` (b, 4) to be computed again.

    Triangles are forgotten (``seen``), chains with a touched point become ``stale``, and links
    there are not ``proved``. ``inside`` (n,) is all False, and becomes True for forgotten
    triangles.
    """
    seen, at, place, rho, state, _, _, stale = triangles
    out, start, first = bent.points, bent.start, traced.first
    _mark_inside(boxes, at, inside)
    for i in range(len(at)):
        if state[i] != 0 and not inside[i]:
            for b in range(len(boxes)):
                inside[i] |= _reaches(boxes, b, place[i, 0], place[i, 1], rho[i])
        if inside[i]:
            seen[i, 0], seen[i, 1], seen[i, 2] = DEAD - 1, DEAD, DEAD
    for c in range(len(first) - 1):
        for p in range(start[c], start[c + 1]):
            touched = False
            for b in range(len(boxes)):
                touched |= _reaches(boxes, b, out[p, 0], out[p, 1], out[p, 2])
            if touched:
                stale[traced.link[first[c]] >> 3] = True
                proved[p] = False
                if p > start[c]:
                    proved[p - 1] = False


@njit(**LEAF)
def _doubtful_sites(sites, forgotten, added, around, doubtful, goes):
    """Mark sites added around a forgotten vertex, and next to those: the reason for them may be
    gone.

    Sets ``goes`` (ghost,), initially False like ``added`` and ``doubtful`` (ghost + 1,); ``around``
    (n,) is working space.
    """
    tri, alias, _, refined, _, used = sites
    any_added = False
    for s in range(used):
        if refined[s]:
            added[alias[s]] = any_added = True
    if not any_added:
        return
    count = 0
    for i in range(len(forgotten)):
        a = np.int64(tri[8 * i])
        if a != DEAD and (
            added[a] or added[np.int64(tri[8 * i + 1])] or added[np.int64(tri[8 * i + 2])]
        ):
            around[count] = 8 * i
            count += 1
    found = True
    while found:
        found = False
        for m in range(count):
            t = around[m]
            touched = forgotten[t >> 3]
            for k in range(3):
                touched |= doubtful[np.int64(tri[t + k])]
            for k in range(3):
                v = np.int64(tri[t + k])
                if touched and added[v] and not doubtful[v]:
                    doubtful[v] = found = True
    for s in range(used):
        goes[s] = refined[s] and doubtful[alias[s]]


@njit(**LEAF)
def _unlink_sites(sites, new_label, doubtful, stands, gone, quiet, heirs):
    """Relabel all sites and find the ones to remove, including the ``doubtful``.

    ``new_label`` is -1 for removed labels. Writes the sites to remove inside the triangulation,
    those to remove outside it, and those to insert because their representative goes; returns their
    numbers. ``stands`` (used,) is all False.
    """
    _, alias, label, refined, also, used = sites
    n_gone, n_quiet, n_heirs = 0, 0, 0
    for p in range(used):
        if label[p] >= 0:
            stands[p] = alias[p] == p
            label[p] = -1 if doubtful[p] else new_label[label[p]]
    for p in range(used):
        if not stands[p]:
            continue
        head = p
        if label[p] < 0:
            gone[n_gone] = p
            n_gone += 1
            head = -1
        last, other = head, also[p]
        also[p] = -1
        while other >= 0:
            after = also[other]
            also[other] = -1
            if label[other] < 0:
                alias[other] = other
                quiet[n_quiet] = other
                n_quiet += 1
            elif head < 0:
                heirs[n_heirs] = other
                n_heirs += 1
                alias[other] = other
                head, last = other, other
            else:
                alias[other] = head
                also[last] = other
                last = other
                # of coincident borders the same one takes over everywhere
                if label[p] < 0 and label[other] < label[head]:
                    label[other], label[head] = label[head], label[other]
                    refined[other], refined[head] = refined[head], refined[other]
            other = after
    return n_gone, n_quiet, n_heirs


@njit(**OWNING, error_model="numpy")
def unlink(boxes, new_label, sites, triangles, traced, bent):
    """Find the sites of removed pieces in a mesh.

    Everything that reaches into the ``boxes`` (b, 4) of changes is to be computed again, without
    the sites added around it. ``new_label`` and the sites returned are as in :func:`_unlink_sites`;
    then come the chains' pieces (p, 2) by new numbers, and flags (p,) of their links still proved.
    """
    n, ghost, used, pieces = len(triangles.seen), len(sites.alias), sites.used, bent.pieces
    proved = bent.proved.copy()
    forgotten = np.zeros(n, np.bool_)
    _forget_touched(boxes, triangles, forgotten, traced, bent, proved)
    doubtful = np.zeros(ghost, np.bool_)
    _doubtful_sites(
        sites, forgotten, np.zeros(ghost + 1, np.bool_), np.empty(n, np.int64),
        np.zeros(ghost + 1, np.bool_), doubtful,
    )  # fmt: skip
    gone, quiet = np.empty(used, np.int64), np.empty(used, np.int64)
    heirs = np.empty(used, np.int32)
    n_gone, n_quiet, n_heirs = _unlink_sites(
        sites, new_label, doubtful, np.zeros(used, np.bool_), gone, quiet, heirs
    )
    new_pieces = np.empty_like(pieces)
    for p in range(len(pieces)):
        new_pieces[p, 0] = new_label[pieces[p, 0]]
        new_pieces[p, 1] = new_label[pieces[p, 1]]
    return gone[:n_gone], quiet[:n_quiet], heirs[:n_heirs], new_pieces, proved
