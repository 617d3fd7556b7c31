"""Where the robot really is, sampled from its pose file 200 times a second. Metres, seconds."""

from __future__ import annotations

import math
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from navigation.simulator.arena import SimulatedArena
from navigation.simulator.shared_pose import PoseFileError, PoseReader
from planner.scene import FloatArray, PolygonRecord, SceneObject, Segment

SAMPLE_S = 0.005
LOOK_EVERY = 10
"""Every so many samples the clearance is looked at, to end a run that has failed."""


class TruthWatch:
    """A thread that notes the true pose; a context manager."""

    def __init__(self, poses: Path, arena: SimulatedArena, radius_m: float) -> None:
        self.arena, self.radius_m = arena, radius_m
        self._reader = PoseReader(poses)
        self._rows: list[tuple[float, float, float, float]] = []
        self._over = threading.Event()
        self.by_hand: list[tuple[float, float]] = []
        """From when to when a hand held the robot: nobody else is to blame for that."""
        self.touched = threading.Event()
        self._thread = threading.Thread(target=self._run, name="truth", daemon=True)

    def __enter__(self) -> TruthWatch:
        self._thread.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self._over.set()
        self._thread.join()

    def _run(self) -> None:
        count = 0
        # The wait is the sampling rate.
        while not self._over.wait(SAMPLE_S):
            try:
                pose = self._reader.read()
            except PoseFileError:
                continue  # the robot is being started
            now_s = time.monotonic()
            self._rows.append((now_s, *pose))
            count += 1
            if count % LOOK_EVERY == 0 and not self.is_by_hand(now_s):
                gap_m = float(self.arena.clearances([pose[:2]])[0]) - self.radius_m
                if gap_m < 0.0:
                    self.touched.set()

    def is_by_hand(self, time_s: float) -> bool:
        return any(begin_s <= time_s <= end_s for begin_s, end_s in self.by_hand)

    def rows(self) -> FloatArray:
        """(n, 4) of monotonic seconds, x_m, y_m, heading_rad."""
        return np.array(self._rows, dtype=np.float64).reshape(-1, 4)

    def lay(self, corners_m: FloatArray) -> None:
        """One more obstacle, a polygon (n, 2), from now on; nobody has been there yet."""
        corners = [(float(x), float(y)) for x, y in corners_m]
        sides = tuple(Segment(corners[i - 1], corners[i]) for i in range(len(corners)))
        scene = self.arena.scene
        laid = SceneObject(len(scene.objects), (PolygonRecord(sides),))
        self.arena = SimulatedArena(replace(scene, objects=(*scene.objects, laid)))

    @property
    def pose(self) -> tuple[float, float, float] | None:
        """The newest."""
        return self._rows[-1][1:] if self._rows else None

    def travelled_m(self) -> float:
        """How far it is from where it began."""
        return math.dist(self._rows[0][1:3], self._rows[-1][1:3]) if self._rows else 0.0
