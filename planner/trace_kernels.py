"""From valid edges to chains: who follows whom.

Rules
- A chain runs from node to node; nodes are vertices with one, three or no two valid edges.
- Triangles and half-edges are named as in :mod:`planner.insertion_kernels`.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: disable-error-code="no-untyped-def,no-untyped-call"

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy")
def trace_chains(tri, mask):
    """Runs of valid edges through vertices with two of them.

    Returns ``node`` (n,) int32, the nodes' triangles, ``ends`` (c, 2) int32 node numbers, and
    offsets ``first`` (c + 1,) into ``link`` (l,) int64, the half-edges crossed from inside, in
    order. A closed run without a node gets one at its first vertex.
    """
    n = len(mask)
    number = np.full(n, -1, np.int32)
    node = np.empty(n, np.int32)
    nodes, total = 0, 0
    for i in range(n):
        m = mask[i]
        degree = int(m & 1) + int((m >> 1) & 1) + int(m >> 2)
        total += degree
        if degree == 1 or degree == 3:
            number[i], node[nodes] = nodes, i
            nodes += 1
    total //= 2
    used = np.zeros(n, np.uint8)
    ends = np.empty((total, 2), np.int32)
    first = np.zeros(total + 1, np.int32)
    link = np.empty(total, np.int64)
    chains, links = 0, 0
    for sweep in range(2):
        for i0 in range(n):
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
    return node[:nodes], ends[:chains], first[: chains + 1], link[:links]
