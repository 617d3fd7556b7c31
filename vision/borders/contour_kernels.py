"""Contour following along the cracks between obstacle and free pixels, and sub-pixel edges.

Rules and units
- The mask has one free pixel of margin on every side and rows of a multiple of eight bytes: 1 is
  obstacle, 0 free. Returned coordinates are without it.
- A crack is the side of an obstacle pixel that faces a free pixel. A border is the closed sequence
  of cracks around one component (clockwise on the screen) or one hole (counter-clockwise): the
  obstacle is always on the right. Obstacles are 8-connected, free space is 4-connected.
- A crack's direction is that of the walk: 0 east (the free pixel lies north), 1 south (it lies
  east), 2 west (south), 3 north (west).
- The search is O(pixels / 8), the rest O(border).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import grown

OBSTACLE = np.uint8(1)
"""Bit 0 of a mask byte: obstacle."""
SEEN = np.uint8(2)
"""Bit 1 of a mask byte: the pixel's west crack has been walked."""
LOW_BITS = np.uint64(0x0101010101010101)
BYTE = np.uint64(8)
LAST_BYTE = np.uint64(56)
ONE = np.uint64(1)
TWO = np.uint64(2)
NORTH, EAST_OF_IT = np.uint64(12), np.uint64(4)
"""Directions 3 and 1, times four; in the latter the free pixel lies in the east."""
WORDS_AT_A_TIME = 32
"""Words of eight pixels searched together."""


@njit(**OWNING)
def follow_borders(mask, xs, ys, directions):
    """Walk every border of the padded mask (h + 2, w') uint8, which is unchanged afterwards.

    ``xs``, ``ys``, ``directions`` are scratch space for the cracks; larger arrays are made if
    needed. Returns ``(x, y, direction, starts, area)``: per crack the obstacle pixel and the walk's
    direction, per border its first crack (one more entry than borders) and the pixels it encloses,
    negative for a hole.
    """
    height, stride = mask.shape
    flat = mask.reshape(-1)
    words = flat.view(np.uint64)
    per_row = stride // 8
    tables = _walk_tables(stride)
    capacity = xs.shape[0]
    count = np.int64(0)
    border_capacity = 64
    starts = np.empty(border_capacity + 1, np.int64)
    areas = np.empty(border_capacity, np.int64)
    borders = 0

    for row in range(1, height - 1):
        row_end = (row + 1) * per_row
        for begin in range(row * per_row, row_end, WORDS_AT_A_TIME):
            end = min(begin + WORDS_AT_A_TIME, row_end)
            if not _any_new(words[begin - 1 : end]):
                continue
            for start in range(8 * begin, 8 * end):
                if flat[start] & 3 != 1 or flat[start - 1] & 1 != 0:
                    continue
                if borders == border_capacity:
                    border_capacity *= 2
                    starts = grown(starts, border_capacity + 1)
                    areas = grown(areas, border_capacity)
                starts[borders] = count
                x = start - row * stride - 1
                last, area = _walk(flat, start, x, row - 1, tables, xs, ys, directions, count)
                while last < 0:
                    # too little space: walk it again
                    capacity *= 2
                    xs = grown(xs, capacity)
                    ys = grown(ys, capacity)
                    directions = grown(directions, capacity)
                    last, area = _walk(flat, start, x, row - 1, tables, xs, ys, directions, count)
                count = last
                areas[borders] = area
                borders += 1
    starts[borders] = count
    for i in range(count):
        if directions[i] == 3:
            mask[ys[i] + 1, xs[i] + 1] = OBSTACLE
    return (
        xs[:count],
        ys[:count],
        directions[:count],
        starts[: borders + 1],
        areas[:borders],
    )


@njit(**LEAF)
def _any_new(words):
    """True if a word other than the first has a west crack not walked yet."""
    before = words[:-1]
    here = words[1:]
    new = np.uint64(0)
    for i in range(here.shape[0]):
        word = here[i]
        new |= word & ~((word << BYTE) | (before[i] >> LAST_BYTE) | (word >> ONE))
    return new & LOW_BITS != 0


@njit(**LEAF)
def _walk(flat, start, x, y, tables, xs, ys, directions, count):
    """Walk one border: ``(end of its cracks, area)``, or -1 if the arrays are too short."""
    move, to_left, to_front, step_x, step_y, turn, seen, area_of_x, begin_left, begin_front = tables
    capacity = xs.shape[0]
    at = np.uint64(start)
    begin = at
    left_at = at + begin_left
    front_at = at + begin_front
    state = NORTH
    area = 0
    while count < capacity:
        # the direction times four; two pixels ahead decide the next
        xs[count] = x
        ys[count] = y
        directions[count] = state >> TWO
        count += 1
        flat[at] |= seen[state]
        area += area_of_x[state] * (x + 1) + (state == EAST_OF_IT)
        left = np.uint64(flat[left_at] & OBSTACLE)
        front = np.uint64(flat[front_at] & OBSTACLE)
        case = state | left << ONE | front
        left_at = at + to_left[case]
        front_at = at + to_front[case]
        at += move[case]
        x += step_x[case]
        y += step_y[case]
        state = turn[case]
        if at == begin and state == NORTH:
            return count, area
    return -1, area


@njit(**OWNING)
def _walk_tables(stride):
    """Tables for a walk without branches.

    By direction * 4 + left * 2 + ahead: the move in bytes; the next two pixels to read, on the left
    and ahead, relative to the old place, so that they need not wait for the next direction; the
    move in x and y; the next direction * 4. By direction * 4: the bit to set, the factor of x in
    the area. Then the first two pixels to read, northwards. Offsets are unsigned and wrap.
    """
    ahead = (1, stride, -1, -stride)
    across = (1, 0, -1, 0)
    down = (0, 1, 0, -1)
    to_left = np.zeros(16, np.uint64)
    to_front = np.zeros(16, np.uint64)
    seen = np.zeros(16, np.uint8)
    area_of_x = np.zeros(16, np.int64)
    move = np.zeros(16, np.uint64)
    step_x = np.zeros(16, np.int64)
    step_y = np.zeros(16, np.int64)
    turn = np.empty(16, np.uint64)
    seen[12] = SEEN
    area_of_x[4] = 1
    area_of_x[12] = -1
    for way in range(4):
        left = (way + 3) & 3
        diagonal = ahead[way] + ahead[left]
        for pixels in range(4):
            case = 4 * way + pixels
            onward = (way + 1) & 3
            moved = 0
            if pixels >= 2:
                moved = diagonal
                step_x[case] = across[way] + across[left]
                step_y[case] = down[way] + down[left]
                onward = left
            elif pixels == 1:
                moved = ahead[way]
                step_x[case] = across[way]
                step_y[case] = down[way]
                onward = way
            next_front = moved + ahead[onward]
            move[case] = np.uint64(np.int64(moved))
            to_front[case] = np.uint64(np.int64(next_front))
            to_left[case] = np.uint64(np.int64(next_front + ahead[(onward + 3) & 3]))
            turn[case] = 4 * onward
    begin_left = np.uint64(np.int64(ahead[3] + ahead[2]))
    begin_front = np.uint64(np.int64(ahead[3]))
    return move, to_left, to_front, step_x, step_y, turn, seen, area_of_x, begin_left, begin_front


@njit(**OWNING)
def hole_owners(mask, xs, ys, directions, starts, areas):
    """Outline of each border: its own index, or for a hole its object's.

    A hole's first crack is the west crack in its topmost row; the run of pixels to its left begins
    with a west crack that an earlier border walked.
    """
    borders = areas.shape[0]
    owners = np.arange(borders)
    holes = 0
    for b in range(borders):
        if areas[b] < 0:
            holes += 1
    if holes == 0:
        return owners
    size = 4
    while size < 4 * holes:
        size *= 2
    keys = np.full(size, -1, np.int64)
    asked = _ask_for_owners(mask, xs, ys, starts, areas, keys)
    found = _walked_by(mask.shape[1], xs, ys, directions, starts, keys)
    for b in range(borders):
        if areas[b] >= 0:
            continue
        slot = _slot(asked[b], size)
        while keys[slot] != asked[b]:
            slot = (slot + 1) & (size - 1)
        owners[b] = owners[found[slot]]
    return owners


@njit(**OWNING)
def _ask_for_owners(mask, xs, ys, starts, areas, keys):
    """Fill the table of ``keys``: for every hole the west crack whose border owns it."""
    borders = areas.shape[0]
    size = keys.shape[0]
    asked = np.full(borders, -1, np.int64)
    for b in range(borders):
        if areas[b] >= 0:
            continue
        x = xs[starts[b]] + 1
        y = ys[starts[b]] + 1
        x -= 1
        while mask[y, x] & 1 == 0:
            x -= 1
        while mask[y, x - 1] & 1:
            x -= 1
        key = np.int64(y) * mask.shape[1] + x
        asked[b] = key
        slot = _slot(key, size)
        while keys[slot] >= 0 and keys[slot] != key:
            slot = (slot + 1) & (size - 1)
        keys[slot] = key
    return asked


@njit(**OWNING)
def _walked_by(stride, xs, ys, directions, starts, keys):
    size = keys.shape[0]
    found = np.full(size, -1, np.int64)
    for b in range(starts.shape[0] - 1):
        for i in range(starts[b], starts[b + 1]):
            if directions[i] != 3:
                continue
            key = np.int64(ys[i] + 1) * stride + xs[i] + 1
            slot = _slot(key, size)
            while keys[slot] >= 0:
                if keys[slot] == key:
                    found[slot] = b
                    break
                slot = (slot + 1) & (size - 1)
    return found


@njit(**OWNING)
def contour_pixels(xs, ys, starts):
    """The 8-connected contours ``(x, y, starts)``: every border's pixels without immediate
    repetition.

    Pixels repeat where the object is one pixel wide.
    """
    borders = starts.shape[0] - 1
    out_x = np.empty(xs.shape[0], np.int32)
    out_y = np.empty(xs.shape[0], np.int32)
    out_starts = np.empty(borders + 1, np.int64)
    count = 0
    for b in range(borders):
        first = count
        out_starts[b] = first
        for i in range(starts[b], starts[b + 1]):
            if count > first and out_x[count - 1] == xs[i] and out_y[count - 1] == ys[i]:
                continue
            out_x[count] = xs[i]
            out_y[count] = ys[i]
            count += 1
        while (
            count > first + 1
            and out_x[count - 1] == out_x[first]
            and out_y[count - 1] == out_y[first]
        ):
            count -= 1
    out_starts[borders] = count
    return out_x[:count].copy(), out_y[:count].copy(), out_starts


@njit(**OWNING)
def _slot(key, size):
    return (key * 2654435761 >> 7) & (size - 1)
