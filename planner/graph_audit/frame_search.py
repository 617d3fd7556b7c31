"""The search for the frame of a graph that lies mostly in obstacles.

- A graph fits as well as the share of its length that keeps the robot's radius, counted at points
  along its edges. A frame is looked for if less than ``LOST_SHARE`` of it does, and offered if
  ``FOUND_SHARE`` of it then does.
- The named frames come first; then, by correlation over all shifts, every turn by ``TURN_STEP_RAD``
  with each scale that makes sense; the best are refined.
- Of equally good fits a named one is offered, else the one that turns least.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from planner.borders.ground import Ground
from planner.graph_audit.edge_lines import EdgeLines
from planner.graph_audit.frame_fit import (
    NEAR_FIT,
    UNIT_SCALES,
    FrameFit,
    map_cell,
    named_frames,
    placed,
)
from planner.graph_audit.unsafe import RADIUS_SLACK
from planner.scene import FloatArray, Scene, Vec

LOST_SHARE, FOUND_SHARE = 0.7, 0.95
"""Free share of a graph that is lost below and found from (chosen: a graph by hand has few edges
in obstacles)."""
HARDLY = 0.3
"""Free share below which a transform is offered though others fit as well (chosen: with more, it
may be a bad graph of the right frame)."""
LEAST_GRAPH_EDGES = 3
"""Fewest edges: fewer fit anywhere (chosen)."""
MOST_COUNTED_POINTS = 2000
"""Points at which a fit is counted (chosen: 0.1 s for all named frames)."""
FEWER = 4
"""Every such point is counted while a fit is refined (chosen: 0.3 s)."""
GRID = 128
"""Cells of the coarse map along its longer side (chosen: 0.5 s for all turns)."""
TURN_STEP_RAD = math.pi / 36.0
"""The end of a graph as long as the map moves by 5 cells of ``GRID``."""
REFINED = 8
"""Coarse fits that are refined (indifferent from 4 to 16)."""
AMPLE_RADII, ROOM_COUNTS = 4.0, 0.1
"""Clearance up to this counts while a fit is refined, and how much (chosen)."""
PROMISING = 0.8
"""Share on the coarse map from which fits are refined (measured: 1.0 for those found on Nav2's
maps, 0.7 for what no frame puts into free space)."""
REFINEMENT_HALVINGS = 6
"""Halvings of a refinement's step: to a 64th of a coarse cell (indifferent from 5 on)."""
SMALLEST_GRAPH, LARGEST_GRAPH = 0.25, 1.5
"""Sizes of the graph, in those of the free space, that make sense (chosen: smaller ones fit
anywhere)."""
OTHER_PLACE = 0.1
"""A fit is another if it moves the nodes by this share of the graph's size (chosen)."""


def find_frame(lines: EdgeLines, scene: Scene, ground: Ground, radius: float) -> FrameFit | None:
    """Return the transform that puts most of a lost graph into free space, None if none does."""
    points = _points_along(lines, radius)
    if len(lines.edges) < LEAST_GRAPH_EDGES or not len(points):
        return None
    search = _Search(points, ground, np.array(scene.view), radius * (1.0 - RADIUS_SLACK))
    before = search.share(points)
    if before >= LOST_SHARE:
        return None
    search = search.in_free_space()
    still = FrameFit(1.0, 0.0, False, (0.0, 0.0), before, before, 0.0)
    named = [
        replace(fit, after=search.fitted(fit))
        for fit in named_frames(still, scene)
        if search.makes_sense(fit.scale)
    ]
    fits = sorted(named, key=lambda fit: -fit.after)
    fits += search.anywhere(still, _scales(scene))
    if not fits:
        return None
    most = max(fit.after for fit in fits)
    good = [fit for fit in fits if fit.after >= most - NEAR_FIT]
    best = min(good, key=lambda fit: (not fit.named, fit.mirrored, abs(fit.turn_rad)))
    if best.after < FOUND_SHARE:
        return None
    size = float(np.ptp(best.placed(points), axis=0).max())
    others = [
        fit.after
        for fit in fits
        if _apart(best.placed(points), fit.placed(points)) > OTHER_PLACE * size
    ]
    best = replace(best, runner_up=max(others, default=before))
    return best if best.sure or before < HARDLY else None


def _apart(places: FloatArray, others: FloatArray) -> float:
    return float(np.hypot(*(places - others).T).mean())


def _points_along(lines: EdgeLines, radius: float) -> FloatArray:
    """Equally spaced points along the edges' lines, those of each line once."""
    rows, edge = lines.pieces()
    rows = rows[np.isin(edge, lines.once())]
    lengths = np.hypot(*(rows[:, 2:] - rows[:, :2]).T)
    total = float(lengths.sum())
    if not 0.0 < total < math.inf:
        return np.empty((0, 2))
    counts = np.maximum(1, np.ceil(MOST_COUNTED_POINTS * lengths / total)).astype(np.int64)
    row = np.repeat(np.arange(len(rows)), counts)
    number = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    part = ((number + 0.5) / counts[row])[:, None]
    points: FloatArray = rows[row, :2] + part * (rows[row, 2:] - rows[row, :2])
    return points


def _scales(scene: Scene) -> list[float]:
    cell = map_cell(scene)
    return [*UNIT_SCALES, *([] if cell is None else [cell, 1.0 / cell])]


@dataclass(frozen=True, slots=True)
class _Search:
    """A graph's points (n, 2), and the ground on which they have to keep the radius."""

    points: FloatArray
    ground: Ground
    box: FloatArray
    radius: float

    def share(self, places: FloatArray) -> float:
        return float((self._clearances(places) >= self.radius).mean())

    def score(self, fit: FrameFit) -> float:
        """Share of a fit, and a little for clearance: of equal fits the one in the middle."""
        clearances = self._clearances(placed(self.points, fit))
        room = np.clip(clearances / (AMPLE_RADII * self.radius), 0.0, 1.0)
        return float((clearances >= self.radius).mean() + ROOM_COUNTS * room.mean())

    def _clearances(self, places: FloatArray) -> FloatArray:
        on = ((places >= self.box[:2]) & (places <= self.box[2:])).all(axis=1)
        clearances = np.full(len(places), -np.inf)
        clearances[on] = self.ground.signed(places[on])
        return clearances

    def fitted(self, fit: FrameFit) -> float:
        return self.share(placed(self.points, fit))

    def in_free_space(self) -> _Search:
        free, cell = self._coarse_map()
        rows, columns = np.nonzero(free)
        if not len(rows):
            return self
        low = self.box[:2] + cell * np.array([columns.min(), rows.min()])
        high = self.box[:2] + cell * (np.array([columns.max(), rows.max()]) + 1.0)
        low, high = np.maximum(low, self.box[:2]), np.minimum(high, self.box[2:])
        return replace(self, box=np.concatenate([low, high]))

    def makes_sense(self, scale: float) -> bool:
        size = float((self.box[2:] - self.box[:2]).max())
        spread = float(np.ptp(self.points, axis=0).max())
        return SMALLEST_GRAPH * size <= scale * spread <= LARGEST_GRAPH * size

    def anywhere(self, still: FrameFit, scales: Sequence[float]) -> list[FrameFit]:
        grid, cell = self._coarse_map()
        coarse: list[tuple[float, FrameFit]] = []
        spectrum = np.fft.rfft2(grid, (2 * GRID, 2 * GRID))
        for scale in dict.fromkeys(scales):
            if not self.makes_sense(scale):
                continue
            for mirrored in (False, True):
                for turn in np.arange(-math.pi, math.pi - 1e-9, TURN_STEP_RAD).tolist():
                    fit = replace(still, scale=scale, turn_rad=turn, mirrored=mirrored)
                    shifted = self._best_shift(fit, spectrum, cell)
                    coarse += [] if shifted is None else [shifted]
        coarse.sort(key=lambda one: -one[0])
        return [self._refined(fit, cell) for _, fit in self._different(coarse)]

    def _coarse_map(self) -> tuple[FloatArray, float]:
        """Free cells of the map (rows, columns) as 1, and their side."""
        width, height = (self.box[2:] - self.box[:2]).tolist()
        cell = max(width, height) / GRID
        columns, rows = max(1, round(width / cell)), max(1, round(height / cell))
        xs = self.box[0] + (np.arange(columns) + 0.5) * cell
        ys = self.box[1] + (np.arange(rows) + 0.5) * cell
        centres = np.stack(np.meshgrid(xs, ys), axis=2).reshape(-1, 2)
        free = self.ground.signed(centres) > self.radius
        return free.reshape(rows, columns).astype(np.float64), cell

    def _best_shift(
        self, fit: FrameFit, spectrum: NDArray[np.complex128], cell: float
    ) -> tuple[float, FrameFit] | None:
        """Shift with the best correlation of the graph's cells with free ones."""
        places = placed(self.points, fit)
        low = places.min(axis=0)
        index = np.floor((places - low) / cell).astype(np.int64)
        if index.max() >= GRID:
            return None
        image = np.zeros((2 * GRID, 2 * GRID))
        np.add.at(image, (index[:, 1], index[:, 0]), 1.0 / len(index))
        scores = np.fft.irfft2(spectrum * np.conj(np.fft.rfft2(image)), image.shape)
        row, column = divmod(int(np.argmax(scores)), 2 * GRID)
        steps = np.array([column, row], np.float64)
        steps[steps >= GRID] -= 2 * GRID
        x, y = (self.box[:2] + steps * cell - low).tolist()
        return float(scores[row, column]), replace(fit, shift=(x, y))

    def _different(self, coarse: list[tuple[float, FrameFit]]) -> list[tuple[float, FrameFit]]:
        kept: list[tuple[float, FrameFit]] = []
        some = self.points[:: max(1, len(self.points) // 64)]
        for score, fit in coarse:
            if score < PROMISING or len(kept) == REFINED:
                break
            places = placed(some, fit)
            size = OTHER_PLACE * float(np.ptp(places, axis=0).max())
            if all(_apart(places, placed(some, one)) > size for _, one in kept):
                kept.append((score, fit))
        return kept

    def _refined(self, fit: FrameFit, cell: float) -> FrameFit:
        few = replace(self, points=self.points[::FEWER])
        best, most = fit, few.score(fit)
        middle = self.points.mean(axis=0, keepdims=True)
        step, turn = cell, 0.5 * TURN_STEP_RAD
        for _ in range(REFINEMENT_HALVINGS):
            better = True
            while better:
                better = False
                for dx, dy, dt in _STEPS:
                    other = _turned_about(best, middle, turn * dt, (step * dx, step * dy))
                    score = few.score(other)
                    if score > most + 1e-9:
                        best, most, better = other, score, True
            step, turn = 0.5 * step, 0.5 * turn
        return replace(best, after=self.fitted(best))


_STEPS = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))


def _turned_about(fit: FrameFit, middle: FloatArray, turn: float, shift: Vec) -> FrameFit:
    before = placed(middle, fit)[0]
    other = replace(fit, turn_rad=math.remainder(fit.turn_rad + turn, math.tau))
    after = placed(middle, other)[0]
    x = fit.shift[0] + float(before[0] - after[0]) + shift[0]
    y = fit.shift[1] + float(before[1] - after[1]) + shift[1]
    return replace(other, shift=(x, y))
