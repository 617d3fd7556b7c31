"""Chains from valid edges: the links of each, and the chains that are unchanged.

Rules
- A chain runs from node to node; nodes are vertices with one or three valid edges. A closed run
  without a node gets one at one of its vertices.
- A chain is its links: the half-edges (:mod:`planner.delaunay.insertion_kernels`) crossed from
  inside, in order.
- Chains that pass no stale triangle and none whose valid edges changed are kept, first and in their
  old order.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.delaunay.triangle_kernels import next_side, previous_side
from planner.diagram.diagram_arrays import Bent
from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import put_rows


@njit(**OWNING, error_model="numpy")
def trace_chains(tri, mask, stale, old):
    """Trace runs of valid edges through vertices with two of them.

    ``mask`` (n,) are every triangle's valid edges, ``stale`` (n,) marks changed triangles. ``old``
    is the previous :class:`planner.diagram.diagram_arrays.Traced`, or an empty one. Returns
    ``kept`` (m,) int32, the old chains that are the first m of the new ones, and for all ``node``
    (n,) int32, the nodes' triangles, ``ends`` (c, 2) int32 node numbers, and offsets ``first`` (c +
    1,) into ``link`` (l,) int64.
    """
    n = len(mask)
    kept, todo = _split_chains(mask, stale, old)
    edges = len(old.link)
    for i in todo:
        edges += int(mask[i] & 1) + int((mask[i] >> 1) & 1) + int(mask[i] >> 2)
    number = np.full(n, -1, np.int32)
    node = np.empty(len(old.node) + len(todo), np.int32)
    used = np.zeros(n, np.uint8)
    ends = np.empty((edges, 2), np.int32)
    first = np.zeros(edges + 1, np.int32)
    link = np.empty(edges, np.int64)
    nodes = _keep_chains(tri, kept, old, number, node, used, ends, first, link)
    count = len(todo)
    for m in range(count):
        i = todo[m]
        if number[i] < 0 and (mask[i] == 7 or mask[i] == 1 or mask[i] == 2 or mask[i] == 4):
            number[i], node[nodes] = nodes, i
            nodes += 1
    chains = len(kept)
    links = np.int64(first[chains])
    for sweep in range(2):
        for m in range(count):
            i0 = todo[m]
            if mask[i0] == used[i0] or (sweep == 0 and number[i0] < 0):
                continue
            if number[i0] < 0:
                number[i0], node[nodes] = nodes, i0
                nodes += 1
            for j0 in range(3):
                if not (mask[i0] & ~used[i0]) >> j0 & 1:
                    continue
                here, way = np.int64(i0), np.int64(j0)
                ends[chains, 0] = number[here]
                while True:
                    link[links] = 8 * here + way
                    links += 1
                    used[here] |= np.uint8(1 << way)
                    o = np.int64(tri[8 * here + way + 4])
                    here, way = o >> 3, o & 3
                    used[here] |= np.uint8(1 << way)
                    if number[here] >= 0:
                        break
                    rest = mask[here] & ~(1 << way)
                    way = np.int64(0 if rest & 1 else (1 if rest & 2 else 2))
                ends[chains, 1] = number[here]
                chains += 1
                first[chains] = links
    return kept, node[:nodes], ends[:chains], first[: chains + 1], link[:links]


@njit(**OWNING, error_model="numpy", inline="always")
def _split_chains(mask, stale, old):
    old_mask, old_node, old_ends, old_first, old_link = old
    n, known = len(mask), len(old_mask)
    changed = np.empty(n, np.bool_)
    for i in range(known):
        changed[i] = stale[i] | (mask[i] != old_mask[i])
    changed[known:] = True
    todo = np.empty(n + len(old_link) + len(old_ends), np.int32)
    count = 0
    for i in range(n):
        if changed[i] and mask[i] != 0:
            todo[count] = i
            count += 1
    kept = np.empty(len(old_ends), np.int32)
    chains = 0
    for c in range(len(old_ends)):
        lo, hi = old_first[c], old_first[c + 1]
        end = old_node[old_ends[c, 1]]
        same = not changed[end]
        for q in range(lo, hi):
            if changed[old_link[q] >> 3]:
                same = False
                break
        if same:
            kept[chains] = c
            chains += 1
            continue
        todo[count] = end
        count += 1
        for q in range(lo, hi):
            todo[count] = old_link[q] >> 3
            count += 1
    return kept[:chains], todo[:count]


@njit(**LEAF)
def _keep_chains(tri, kept, old, number, node, used, ends, first, link):
    """Write the ``kept`` chains into node, ends, first and link; return their number of nodes.

    ``number`` gets the nodes' numbers and ``used`` the edges at which the chains leave them.
    """
    old_node, old_ends, old_first, old_link = old.node, old.ends, old.first, old.link
    nodes, links = 0, 0
    for m in range(len(kept)):
        c = kept[m]
        lo, hi = old_first[c], old_first[c + 1]
        for side in range(2):
            i = old_node[old_ends[c, side]]
            if number[i] < 0:
                number[i], node[nodes] = nodes, i
                nodes += 1
            ends[m, side] = number[i]
        for q in range(lo, hi):
            link[links] = old_link[q]
            links += 1
        used[old_link[lo] >> 3] |= np.uint8(1 << (old_link[lo] & 3))
        o = np.int64(tri[old_link[hi - 1] + 4])
        used[o >> 3] |= np.uint8(1 << (o & 3))
        first[m + 1] = links
    return nodes


@njit(**OWNING, error_model="numpy")
def lay_straight(mesh, at, first, link):
    """Lay the chains as straight links between the centres ``at`` (t, 2) of their triangles.

    Returns ``points`` (p, 2), ``pieces`` (p, 2) and offsets (c + 1,) as in
    :class:`planner.diagram.diagram_arrays.Bent`.
    """
    tri, label = mesh.tri, mesh.label
    c = len(first) - 1
    points = np.empty((len(link) + c, 2))
    pieces = np.full((len(link) + c, 2), -1, np.int32)
    for j in range(c):
        for q in range(first[j], first[j + 1] + 1):
            h = link[q] if q < first[j + 1] else np.int64(tri[link[q - 1] + 4])
            i, k = h >> 3, h & 7
            points[q + j, 0], points[q + j, 1] = at[i, 0], at[i, 1]
            if q < first[j + 1]:
                pieces[q + j, 0] = label[np.int64(tri[8 * i + previous_side(k)])]
                pieces[q + j, 1] = label[np.int64(tri[8 * i + next_side(k)])]
    return points, pieces, first + np.arange(c + 1, dtype=np.int32)


@njit(**OWNING, error_model="numpy")
def join_chains(kept, old, new):
    """The kept chains' points and then the new ones'.

    All are :class:`planner.diagram.diagram_arrays.Bent`.
    """
    old_out, old_pair, old_start, old_proved = old
    new_out, new_pair, start, new_proved = new
    m = len(kept)
    offsets = np.empty(m + len(start), np.int32)
    n = 0
    for c in range(m):
        offsets[c] = n
        n += old_start[kept[c] + 1] - old_start[kept[c]]
    for c in range(len(start)):
        offsets[m + c] = n + start[c]
    total = n + len(new_out)
    out, pair = np.empty((total, 3)), np.empty((total, 2), np.int32)
    proved = np.empty(total, np.bool_)
    c = 0
    while c < m:
        # copy consecutive chains at once
        last = c
        while last + 1 < m and kept[last + 1] == kept[last] + 1:
            last += 1
        lo, hi = old_start[kept[c]], old_start[kept[last] + 1]
        to = offsets[c]
        put_rows(out, to, old_out[lo:hi])
        put_rows(pair, to, old_pair[lo:hi])
        put_rows(proved, to, old_proved[lo:hi])
        c = last + 1
    put_rows(out, n, new_out)
    put_rows(pair, n, new_pair)
    put_rows(proved, n, new_proved)
    return Bent(out, pair, offsets, proved)
