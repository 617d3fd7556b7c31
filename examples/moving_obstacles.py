"""Moving obstacles: a roadmap that is updated as one obstacle moves, and plans that follow.

    python examples/moving_obstacles.py [FOLDER]

`Roadmap.updated` finds out by itself what has changed and keeps the rest. `near` keeps the plan on
the same side of the obstacle as long as that is as good, so that it does not jump. Metres.
"""

import sys
import time
from pathlib import Path

import navigation
import planner

ARENA = """\
#@ clearway.scene/1
#@ units m
#@ bounds given 0 0 4 3
L 4 (1.2,0.0) (1.2,0.9) (1.4,0.9) (1.4,0.0)
L 3 (2.9,0.3) (3.1,1.0) (3.4,0.4)
C ({x:.3f},{y:.3f}) 0.3
"""
STEPS = 8


def scene_at(step: int) -> planner.Scene:
    """The disc rolls from the upper left to the lower right."""
    part = step / (STEPS - 1)
    return planner.read_scene_text(ARENA.format(x=1.2 + 1.1 * part, y=2.3 - 1.4 * part))


def main(folder: Path) -> None:
    """Write moving_obstacles.svg: the last scene, its roadmap and plan, and the earlier plans."""
    roadmap = planner.build_roadmap(scene_at(0), radius=0.15)
    path = None
    earlier = []
    for step in range(STEPS):
        began_s = time.perf_counter()
        roadmap = roadmap.updated(scene_at(step))
        took_ms = 1000 * (time.perf_counter() - began_s)
        path = roadmap.plan((0.4, 0.5), (3.6, 2.4), near=path)
        if isinstance(path, planner.NoPath):
            print(f"step {step}: {path.reason}")
            continue
        print(
            f"step {step}: updated in {took_ms:5.1f} ms, a path of {path.length:.2f} m"
            f" with a clearance of {path.min_clearance:.2f} m"
        )
        earlier.append(path.points)
    navigation.save_picture(
        folder / "moving_obstacles.svg", roadmap.scene, roadmap, path, earlier=earlier[:-1]
    )


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
