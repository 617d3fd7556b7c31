"""Clearance: the exact distance of places, and of whole lines, to the nearest obstacle.

    python examples/clearance_queries.py [FOLDER]

Nothing is sampled and no grid is made: distances are those to the lines and arcs of the scene. The
picture (Matplotlib) shows the clearance of 300 x 225 places as colours. Everything is in metres.
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
#@ bounds given 0 0 4 3
C (2.0,1.9) 0.4
L 4 (1.2,0.0) (1.2,0.9) (1.4,0.9) (1.4,0.0)
L 3 (2.9,0.6) (3.3,1.5) (3.5,0.8)
"""


def main(folder: Path) -> None:
    """Write clearance.png."""
    scene = planner.read_scene_text(ARENA)
    roadmap = planner.build_roadmap(scene, radius=0.2)

    places = [(0.6, 0.6), (2.0, 1.9), (2.2, 0.8)]
    for (x, y), clearance in zip(places, roadmap.clearance(places), strict=True):
        inside = "  (inside an obstacle)" if clearance < 0 else ""
        print(f"clearance at ({x}, {y}): {clearance:.4f} m{inside}")

    line = [(0.4, 2.6), (2.2, 2.5), (3.6, 1.9)]
    least = roadmap.path_clearance(line)
    print(f"the line comes as near as {least.distance:.4f} m, to obstacle {least.owner}")

    x, y = np.meshgrid(np.linspace(0, 4, 300), np.linspace(0, 3, 225))
    field = roadmap.clearance(np.column_stack((x.ravel(), y.ravel()))).reshape(x.shape)
    figure, axes = plt.subplots(figsize=(8, 5.4), layout="constrained")
    filled = axes.contourf(x, y, np.where(field < 0, np.nan, field), levels=20, cmap="viridis")
    figure.colorbar(filled, label="clearance in m")
    axes.contour(x, y, field, levels=[0.2], colors="white", linewidths=1.0)
    axes.plot(*np.transpose(line), color="tab:red")
    axes.plot(*least.at, "o", color="tab:red")
    axes.set(
        aspect="equal",
        xlabel="x in m",
        ylabel="y in m",
        title="Within the white line a robot of 0.2 m fits",
    )
    figure.savefig(folder / "clearance.png", dpi=120)
    plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
