"""What counts as getting on: the way that is left, not the states that are gone through."""

from __future__ import annotations

import pytest

from navigation.mission.late_pictures import speed_with
from navigation.mission.progress import DETOURS, Progress


def looked(progress: Progress, seconds: float, **facts: object) -> None:
    facts = {"waits": True, "visited": 0, "left_m": None, "revision": 1, **facts}
    start_s = progress._looked_s or 0.0
    for i in range(round(seconds * 10)):
        progress.look(start_s + 0.1 * (i + 1), **facts)  # type: ignore[arg-type]


def test_only_waiting_counts() -> None:
    progress = Progress()
    looked(progress, 5.0)
    looked(progress, 20.0, waits=False)
    assert progress.waited_s == pytest.approx(4.9, abs=0.11)


def test_a_time_in_which_the_program_did_not_run_is_no_waiting() -> None:
    progress = Progress()
    looked(progress, 5.0)
    assert progress._looked_s is not None
    facts = {"waits": True, "visited": 0, "left_m": None, "revision": 1}
    progress.look(progress._looked_s + 3600.0, **facts)  # type: ignore[arg-type]
    assert progress.waited_s < 7.0


def test_a_robot_that_is_pushed_back_time_and_again_gets_nowhere() -> None:
    progress = Progress()
    for _ in range(20):
        looked(progress, 1.0)
        for left_m in (2.0, 1.9, 1.8, 1.7):
            looked(progress, 1.0, waits=False, left_m=left_m)
    assert progress.waited_s == pytest.approx(19.0, abs=0.3), "only the first time was progress"


def test_each_time_nearer_is_progress_and_so_is_a_station() -> None:
    progress = Progress()
    for left_m in (2.0, 1.95, 1.9):
        looked(progress, 5.0)
        looked(progress, 0.1, waits=False, left_m=left_m)
        assert progress.waited_s == 0.0
    looked(progress, 5.0)
    looked(progress, 0.1, visited=1)
    assert progress.waited_s == 0.0
    looked(progress, 5.0)
    looked(progress, 0.1, waits=False, left_m=7.0, visited=1)
    assert progress.waited_s == 0.0, "the next station's way is measured afresh"


def test_a_new_scene_may_lengthen_the_way_but_not_for_ever() -> None:
    progress = Progress()
    looked(progress, 0.1, waits=False, left_m=1.0)
    for revision in range(2, 40):
        looked(progress, 1.0)
        for left_m in (3.0, 2.9):
            looked(progress, 0.1, waits=False, left_m=left_m, revision=revision)
    assert progress.waited_s > 39 - 3 - DETOURS


def test_late_pictures_ask_for_slower_driving_and_the_stopping_way_stays() -> None:
    assert speed_with(0.0, 0.3, 0.5) == speed_with(0.15, 0.3, 0.5) == 0.3
    speeds = [speed_with(late_s, 0.3, 0.5) for late_s in (0.15, 0.2, 0.3, 0.6, 2.0)]
    assert speeds == sorted(speeds, reverse=True)
    ways = [
        v * (0.07 + late_s) + v * v / 1.0
        for v, late_s in zip(speeds, (0.15, 0.2, 0.3, 0.6, 2.0), strict=True)
    ]
    assert ways == pytest.approx([ways[0]] * 5)
