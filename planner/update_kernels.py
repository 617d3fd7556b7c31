"""What of a solved mesh a change of objects touches.

Rules and units
- Everything is in the scene's units. A place is touched where an object that comes or goes
  reaches into its circle, or may lie around it: judged by the objects' boxes, generously.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: disable-error-code="no-untyped-def,no-untyped-call"

from __future__ import annotations

import numpy as np
from numba import njit

from planner.insertion_kernels import DEAD

SLACK = 1e-9
"""Circles count as larger by this share."""


@njit(cache=True, nogil=True, error_model="numpy")
def _reaches(boxes, x, y, r):
    """Whether any box comes within r of (x, y)."""
    for b in range(len(boxes)):
        dx = max(boxes[b, 0] - x, 0.0, x - boxes[b, 2])
        dy = max(boxes[b, 1] - y, 0.0, y - boxes[b, 3])
        if dx * dx + dy * dy <= r * r * (1.0 + SLACK):
            return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def forget_touched(boxes, at, place, rho, state, seen, stale, first, link, out, start):
    """Make everything in the ``boxes`` (b, 4) be computed again.

    Triangles are forgotten (``seen``), and chains with a touched point become ``stale``.
    """
    for i in range(len(at)):
        if np.int64(seen[i, 0]) == DEAD:
            continue
        if _reaches(boxes, at[i, 0], at[i, 1], 0.0) or (
            state[i] != 0 and _reaches(boxes, place[i, 0], place[i, 1], rho[i])
        ):
            seen[i, 0], seen[i, 1], seen[i, 2] = DEAD - 1, DEAD, DEAD
    for c in range(len(first) - 1):
        for p in range(start[c], start[c + 1]):
            if _reaches(boxes, out[p, 0], out[p, 1], out[p, 2]):
                stale[link[first[c]] >> 3] = True
                break


@njit(cache=True, nogil=True, error_model="numpy")
def unlink_sites(label, new_label, alias, also, used):
    """Give all sites their new labels and find out which have to go.

    ``new_label`` holds -1 for labels that are no more. Returns the sites that are in the
    triangulation and go, those that go without being in it, and those that have to be put in
    because the site that stood for them goes.
    """
    gone, quiet = np.empty(used, np.int64), np.empty(used, np.int64)
    heirs = np.empty(used, np.int32)
    n_gone, n_quiet, n_heirs = 0, 0, 0
    stands = np.zeros(used, np.bool_)
    for p in range(used):
        if label[p] >= 0:
            stands[p] = alias[p] == p
            label[p] = new_label[label[p]]
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
            other = after
    return gone[:n_gone], quiet[:n_quiet], heirs[:n_heirs]


@njit(cache=True, nogil=True, error_model="numpy")
def _ranges(owner, begin, end, objects):
    """First index and count of every object's pieces among ``begin`` to ``end``; bounds last."""
    first, count = np.zeros(objects + 1, np.int64), np.zeros(objects + 1, np.int64)
    for i in range(end - 1, begin - 1, -1):
        o = owner[i] if owner[i] >= 0 else objects
        first[o] = i
        count[o] += 1
    return first, count


@njit(cache=True, nogil=True, error_model="numpy")
def gather_kept(
    kept, objects, kind, data, owner, border, is_hole, backwards,
    new_kind, new_data, new_owner, new_border, new_is_hole, new_backwards
):  # fmt: skip
    """Flat primitives of objects that were there before, of new ones, and of the old bounds.

    ``kept`` (n,) is which of the old ``objects`` each one is, -1 for the new ones in turn.
    Returns kind, data, owner, border, is_hole, reversed as in
    :class:`planner.scene.Primitives`.
    """
    n = len(kept)
    came = 0
    for j in range(n):
        came += kept[j] < 0
    first, count = _ranges(owner, 0, len(owner), objects)
    new_first, new_count = _ranges(new_owner, 0, len(new_owner), came)
    total, came = count[objects], 0
    for j in range(n):
        if kept[j] >= 0:
            total += count[kept[j]]
        else:
            total += new_count[came]
            came += 1
    most = 0
    for i in range(len(border)):
        most = max(most, border[i] + 1)
    out_kind, out = np.empty(total, np.int8), np.empty((total, 6))
    out_owner, out_border = np.empty(total, np.int32), np.empty(total, np.int32)
    out_hole, out_backwards = np.empty(total, np.bool_), np.empty(total, np.bool_)
    m, came = 0, 0
    for j in range(n + 1):
        if j < n and kept[j] < 0:
            for i in range(new_first[came], new_first[came] + new_count[came]):
                out_kind[m], out_owner[m], out_border[m] = new_kind[i], j, most + new_border[i]
                out_hole[m], out_backwards[m] = new_is_hole[i], new_backwards[i]
                for c in range(6):
                    out[m, c] = new_data[i, c]
                m += 1
            came += 1
            continue
        old = kept[j] if j < n else objects
        for i in range(first[old], first[old] + count[old]):
            out_kind[m], out_owner[m], out_border[m] = kind[i], j if j < n else -1, border[i]
            out_hole[m], out_backwards[m] = is_hole[i], backwards[i]
            for c in range(6):
                out[m, c] = data[i, c]
            m += 1
    return out_kind, out, out_owner, out_border, out_hole, out_backwards


@njit(cache=True, nogil=True, error_model="numpy")
def relabel(kept, objects, old_owner, old_k, new_owner, new_k):
    """Where the pieces of kept objects and of the bounds are now, and whether they correspond.

    ``kept`` as in :func:`gather_kept`, of the old and new pieces the first ``old_k`` and
    ``new_k`` are primitives. The labels (p + 1,) are -1 for pieces that are no more, and at
    the end.
    """
    label = np.full(len(old_owner) + 1, -1, np.int32)
    n = len(kept)
    for part in range(2):
        if part == 0:
            first, count = _ranges(old_owner, 0, old_k, objects)
            new_first, new_count = _ranges(new_owner, 0, new_k, n)
        else:
            first, count = _ranges(old_owner, old_k, len(old_owner), objects)
            new_first, new_count = _ranges(new_owner, new_k, len(new_owner), n)
        for j in range(n + 1):
            old = objects
            if j < n:
                old = kept[j]
            if old < 0:
                continue
            if count[old] != new_count[j]:
                return label, False
            for i in range(count[old]):
                label[first[old] + i] = new_first[j] + i
    return label, True


@njit(cache=True, nogil=True, error_model="numpy")
def corners_of(which, owner, k, before, after, offset):
    """An object's corner points: first, last + 1, and what meets there less ``offset``."""
    lo, hi = 0, 0
    for c in range(len(before)):
        if owner[k + c] == which:
            if hi == 0:
                lo = c
            hi = c + 1
    before, after = before[lo:hi].copy(), after[lo:hi].copy()
    for c in range(hi - lo):
        if before[c] >= 0:
            before[c] -= offset
        if after[c] >= 0:
            after[c] -= offset
    return lo, hi, before, after
