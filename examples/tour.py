"""A tour: several stations, in the order given and in the order that makes the path shortest.

    python examples/tour.py [FOLDER]

Everything is in metres; the robot is a disc with a radius of 0.12 m.
"""

import sys
from pathlib import Path

import navigation
import planner

ARENA = """\
#@ clearway.scene/1
#@ units m
#@ bounds given 0 0 6 4
C (1.5,1.4) 0.5
C (4.6,2.6) 0.6
L 4 (2.6,0.0) (2.6,1.8) (2.8,1.8) (2.8,0.0)
L 4 (3.0,4.0) (3.2,4.0) (3.2,2.6) (3.0,2.6)
"""
START, GOAL = (0.4, 0.4), (5.6, 0.4)
STATIONS = [(5.5, 3.5), (0.5, 3.4), (3.6, 0.6), (2.2, 3.3)]


def main(folder: Path) -> None:
    """Write tour.svg."""
    scene = planner.read_scene_text(ARENA)
    roadmap = planner.build_roadmap(scene, radius=0.12)
    given = roadmap.plan(START, GOAL, via=STATIONS)
    best = roadmap.plan(START, GOAL, via=STATIONS, order="best")
    if isinstance(given, planner.NoPath) or isinstance(best, planner.NoPath):
        sys.exit("there is no path")
    print(f"in the order given: {given.length:.2f} m")
    print(f"in the best order {best.order}: {best.length:.2f} m")
    stations = [START, *(STATIONS[number] for number in best.order), GOAL]
    navigation.save_picture(folder / "tour.svg", scene, roadmap, best, stations=stations)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
