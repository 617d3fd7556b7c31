"""Order of the robots at shared places, from tracks that never touch.

- Pieces of two tracks that come nearer than the gap are a shared place. The robot that passes it
  first in the plan, exactly, always does: the other begins its piece only after the first has ended
  its own.
- While the waits form no circle, some robot can always continue (Hoenig et al., "Persistent and
  robust execution of MAPF schedules in warehouses", RA-L 2019).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from planner.fleet.fleet_plan import Dependency
from planner.fleet.motions.track_kernels import order_of_pair
from planner.scene import FloatArray, IntArray


def find_dependencies(tracks: Sequence[FloatArray], radii: Sequence[float]) -> list[Dependency]:
    """All waits, except those implied by others of the same two robots."""
    found: list[Dependency] = []
    for i in range(len(tracks)):
        for j in range(i + 1, len(tracks)):
            later, sooner = order_of_pair(_drawn(tracks[i]), _drawn(tracks[j]), radii[i] + radii[j])
            found += _waits(i, j, later) + _waits(j, i, sooner)
    return found


def _drawn(track: FloatArray) -> FloatArray:
    return track if len(track) > 1 else np.vstack([track, track])


def _waits(first: int, waiting: int, rows: IntArray) -> list[Dependency]:
    """Waits of one robot for another, each asking for more than the ones before."""
    asked, found = 0, []
    for row, passed in enumerate(rows.tolist()):
        if passed > asked:
            asked = passed
            found.append((first, passed, waiting, row))
    return found


def is_live(tracks: Sequence[FloatArray], dependencies: Sequence[Dependency]) -> bool:
    """True if the waits form no circle: whatever the delays, all robots arrive.

    Events are the robots' points; each follows the one before it and those its robot waits for.
    """
    first = np.concatenate([[0], np.cumsum([len(track) for track in tracks])])
    after: list[list[int]] = [[] for _ in range(int(first[-1]))]
    waits = [0] * len(after)

    def put(sooner: int, later: int) -> None:
        after[sooner].append(later)
        waits[later] += 1

    for i, track in enumerate(tracks):
        for row in range(len(track) - 1):
            put(int(first[i]) + row, int(first[i]) + row + 1)
    for i, passed, j, row in dependencies:
        if passed >= len(tracks[i]) or row + 1 >= len(tracks[j]):
            continue
        put(int(first[i]) + passed, int(first[j]) + row + 1)
    ready = deque(event for event, count in enumerate(waits) if count == 0)
    done = 0
    while ready:
        done += 1
        for later in after[ready.popleft()]:
            waits[later] -= 1
            if waits[later] == 0:
                ready.append(later)
    return done == len(after)
