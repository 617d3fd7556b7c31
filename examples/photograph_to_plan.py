"""A photograph to a plan, in ten lines.

    python examples/photograph_to_plan.py [FOLDER]

Coordinates are the photograph's pixels, x right, y down; the robot is a disc of 18 pixels.
"""

import sys
from pathlib import Path

import cv2

import navigation
import planner
import vision


def main(folder: Path) -> None:
    """Write plan.svg."""
    picture = planner.sample("photograph")  # or a picture of yours
    scene = vision.extract(cv2.imread(str(picture), cv2.IMREAD_GRAYSCALE))
    roadmap = planner.build_roadmap(scene, radius=18.0)
    path = roadmap.plan(start=(40, 440), goal=(600, 40))
    if isinstance(path, planner.NoPath):
        sys.exit(path.reason)
    print(f"{len(scene.objects)} obstacles, a path of {path.length:.0f} px")
    print(
        f"least clearance {path.min_clearance:.1f} px, exact, for a robot of {path.robot_radius:g}"
    )
    navigation.save_picture(folder / "plan.svg", scene, roadmap, path)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
