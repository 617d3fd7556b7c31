"""Several robots at once: they change sides through one gap, and no two of them ever touch.

    python examples/fleet.py [FOLDER]

Everything is in metres and seconds. The robots are discs of two sizes. The picture (Matplotlib) shows
the track of each, and its disc once a second.
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import planner

ARENA = """\
#@ clearway.scene/1
#@ units m
#@ bounds given 0 0 6 4
L 4 (2.7,0.0) (2.7,1.7) (3.3,1.7) (3.3,0.0)
L 4 (2.7,4.0) (3.3,4.0) (3.3,2.4) (2.7,2.4)
C (1.2,2.0) 0.3
C (4.8,2.0) 0.3
"""
NAMES = ["ada", "bob", "cem"]
STARTS = [(0.5, 1.0), (5.5, 3.2), (0.5, 3.2)]
GOALS = [(5.5, 1.0), (0.5, 2.0), (5.5, 2.0)]
RADII = [0.18, 0.18, 0.25]
MARGIN = 0.02
"""What each robot keeps on top of its radius."""


def main(folder: Path) -> None:
    """Write fleet.png."""
    scene = planner.read_scene_text(ARENA)
    wide = [radius + MARGIN for radius in RADII]
    roadmap = planner.build_roadmap(scene, radius=min(wide))
    plan = planner.plan_fleet(roadmap, STARTS, GOALS, wide)
    if isinstance(plan, planner.NoFleetPlan):
        sys.exit(f"there is no plan: {plan.reason}")
    for name, track in zip(NAMES, plan.tracks, strict=True):
        print(f"{name} arrives after {track[-1, 0]:.1f} s")
    print(f"the least gap between two of them: {least_gap(plan):.3f} m")
    draw(scene, plan, folder / "fleet.png")


def least_gap(plan: planner.FleetPlan) -> float:
    """Between the borders of the nearest two robots, looked at every hundredth of a second."""
    times = np.arange(0.0, plan.makespan_s, 0.01)
    gaps = []
    for i, one in enumerate(plan.tracks):
        for j, other in enumerate(plan.tracks[:i]):
            apart = place_at(one, times) - place_at(other, times)
            gaps.append(np.hypot(*apart.T).min() - RADII[i] - RADII[j])
    return min(gaps)


def place_at(track: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Where a robot is at each of these times; a track is rows of t, x and y."""
    return np.column_stack([np.interp(times, track[:, 0], track[:, axis]) for axis in (1, 2)])


def draw(scene: planner.Scene, plan: planner.FleetPlan, file: Path) -> None:
    """Each robot's track, and its disc once a second."""
    figure, axes = plt.subplots(figsize=(9, 6), layout="constrained")
    scene.plot(axes)
    for number, (name, track) in enumerate(zip(NAMES, plan.tracks, strict=True)):
        colour = f"C{number}"
        axes.plot(track[:, 1], track[:, 2], color=colour, label=name)
        for place in place_at(track, np.arange(0.0, track[-1, 0], 1.0)):
            axes.add_patch(plt.Circle(place, RADII[number], color=colour, alpha=0.15))
    axes.legend(loc="upper center", ncols=len(NAMES))
    axes.set(aspect="equal", xlabel="x in m", ylabel="y in m", title="Each robot once a second")
    figure.savefig(file, dpi=100)
    plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
