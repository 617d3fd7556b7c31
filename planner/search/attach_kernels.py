"""Attaching a place to the roadmap's chains by retraction, on flat arrays.

Rules and units
- Chains and links are those of :mod:`planner.search.chain_graph_kernels`.
- Retraction leads away from the nearest border until a second one is as near, and onto the chain.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.borders.box_tree_kernels import nearest, polyline_clearance
from planner.diagram.bisector_kernels import slide_between
from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import foot, point_to_segment
from planner.search.chain_graph_kernels import Gates

SHRINKS = 60
"""Most steps of the shrinking ball; 12 suffice on random scenes."""


@njit(**BORROWING)
def retract(tree, x, y, reach):
    """Move (x, y) away from the nearest border until a second border is as near.

    The shrinking ball of Ma, Bae and Choi (2012): a ball through the nearest foot, centred on the
    ray from it through (x, y), shrinks until it contains no border. Returns centre, radius and both
    primitives. ``reach`` is the first radius, above any clearance in the scene.
    """
    kind, data = tree.kind, tree.data
    d, a = nearest(tree, x, y, np.inf)
    fx, fy = foot(kind, data, a, x, y)
    if d <= 0.0:
        return x, y, d, a, a
    nx, ny = (x - fx) / d, (y - fy) / d
    r, b = max(reach, d), a
    for _ in range(SHRINKS):
        cx, cy = fx + r * nx, fy + r * ny
        _, i = nearest(tree, cx, cy, r * (1.0 - 1e-12))
        if i < 0:
            break
        qx, qy = foot(kind, data, i, cx, cy)
        wx, wy = qx - fx, qy - fy
        along = nx * wx + ny * wy
        if along <= 0.0:
            break
        smaller = 0.5 * (wx * wx + wy * wy) / along
        if smaller < d:
            r, b = d, i
            break
        if smaller >= r:
            break
        r, b = smaller, i
    return fx + r * nx, fy + r * ny, r, a, b


@njit(**OWNING)
def nearest_links(points, first, x, y, count):
    """Links nearest to (x, y), at most one a chain: chain, point index, part, distance."""
    chain = np.full(count, -1, np.int32)
    link = np.zeros(count, np.int32)
    part = np.zeros(count)
    away = np.full(count, np.inf)
    for c in range(len(first) - 1):
        best, bi, bt = away[count - 1], -1, 0.0
        for i in range(first[c], max(first[c] + 1, first[c + 1] - 1)):
            j = min(i + 1, first[c + 1] - 1)
            ax, ay, bx, by = points[i, 0], points[i, 1], points[j, 0], points[j, 1]
            dx = max(min(ax, bx) - x, x - max(ax, bx))
            dy = max(min(ay, by) - y, y - max(ay, by))
            if dx >= best or dy >= best:
                continue
            d, t = point_to_segment(x, y, ax, ay, bx, by)
            if d < best:
                best, bi, bt = d, i, t
        if bi < 0:
            continue
        k = count - 1
        while k > 0 and away[k - 1] > best:
            chain[k], link[k], part[k], away[k] = (
                chain[k - 1],
                link[k - 1],
                part[k - 1],
                away[k - 1],
            )
            k -= 1
        chain[k], link[k], part[k], away[k] = c, bi, bt, best
    return chain, link, part, away


@njit(**BORROWING)
def _to_ends(graph, chain, link, part, out):
    """Write cost and clearance from a place inside a chain to its first and last point.

    Clearance is monotone along a proved link. The access includes the place's own.
    """
    first, rho, gap, proved = (
        graph.chains.first,
        graph.chains.rho,
        graph.chains.gap,
        graph.chains.proved,
    )
    cost = graph.cost
    lo, hi = first[chain], first[chain + 1] - 1
    if lo == hi:
        out[0], out[1], out[2], out[3] = 0.0, rho[lo], 0.0, rho[lo]
        return
    out[0], out[1] = part * cost[link], rho[link] if proved[link] else gap[link]
    for i in range(lo, link):
        out[0] += cost[i]
        out[1] = min(out[1], gap[i])
    out[2], out[3] = (1.0 - part) * cost[link], rho[link + 1] if proved[link] else gap[link]
    for i in range(link + 1, hi):
        out[2] += cost[i]
        out[3] = min(out[3], gap[i])


@njit(**OWNING)
def attach(tree, graph, x, y, floor, within, rounding, tolerance, reach, most):
    """Ways from (x, y) onto at most ``most`` chains, with clearance >= ``floor``, nearest first.

    If retraction ends within ``within`` of a chain, use it and any equally near up to ``rounding``;
    else any of the nearest chains that a straight line reaches.
    """
    points, first, pieces = graph.chains.points, graph.chains.first, graph.chains.pieces
    rx, ry, _, _, _ = retract(tree, x, y, reach)
    chain, link, part, away = nearest_links(points, first, rx, ry, most)
    where = np.empty((most, 2), np.int32)
    access = np.empty((most, 3, 2))
    price = np.empty((most, 7))
    met = away[0] <= within
    m = 0
    for k in range(most):
        c, i = chain[k], link[k]
        if c < 0 or (met and m > 0 and away[k] > away[0] + rounding):
            break
        j = min(i + 1, first[c + 1] - 1)
        px = points[i, 0] + part[k] * (points[j, 0] - points[i, 0])
        py = points[i, 1] + part[k] * (points[j, 1] - points[i, 1])
        if graph.chains.proved[i]:
            px, py, _ = slide_between(
                tree.kind, tree.data, np.int64(pieces[i, 0]), np.int64(pieces[i, 1]), px, py,
                tolerance,
            )  # fmt: skip
        access[m, 0, 0], access[m, 0, 1] = x, y
        access[m, 1, 0], access[m, 1, 1] = rx, ry
        access[m, 2, 0], access[m, 2, 1] = px, py
        clear = polyline_clearance(tree, access[m])[0]
        if clear < floor:
            continue
        where[m, 0], where[m, 1] = c, i
        price[m, 0], price[m, 2] = part[k], clear
        price[m, 1] = math.sqrt((rx - x) ** 2 + (ry - y) ** 2) + away[k]
        _to_ends(graph, c, i, part[k], price[m, 3:])
        m += 1
    return Gates(where[:m].copy(), access[:m].copy(), price[:m].copy())
