r"""Names in a triangulation: triangles, their sides, and half-edges.

Rules
- Triangle t owns tri[8t : 8t + 8]: three sites, a spare, three links, a spare. Its name is 8 t;
  8 t + k names its half-edge k, opposite its site k, from site k + 1 to site k + 2, counted round
  the triangle. Link k holds the half-edge on its other side:

            site k                h = 8 t + k
             /  \                 tri[h]                        its opposite site
            /  t \                tri[h + 4]                    its other side
      k + 1 ------ k + 2          triangle_of(h)                8 t
         half-edge k ->           8 t + next_side(k)            half-edge k + 1
            \    /                8 t + previous_side(k)        half-edge k + 2
             \  /
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from numba import njit

from planner.scene.compile_options import LEAF

DEAD = 0xFFFFFFFF
"""The first site of a triangle that does not exist."""


@njit(**LEAF, forceinline=True)
def next_side(k):
    """Side after side k, counter-clockwise: 1, 2, 0."""
    return (9 >> (2 * k)) & 3


@njit(**LEAF, forceinline=True)
def previous_side(k):
    """Side before side k, counter-clockwise: 2, 0, 1."""
    return (18 >> (2 * k)) & 3


@njit(**LEAF, forceinline=True)
def side_of(half_edge):
    """Side of its triangle that a half-edge is."""
    return half_edge & 3


@njit(**LEAF, forceinline=True)
def triangle_of(half_edge):
    """Triangle of a half-edge, as 8 t."""
    return (half_edge >> 3) << 3
