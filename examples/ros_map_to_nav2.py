"""A ROS map to a graph for Nav2's route server.

    python examples/ros_map_to_nav2.py [FOLDER]

Writes a small map as `map_saver` does (map.yaml and map.pgm), builds its roadmap for a robot with a
radius of 0.22 m, and writes it as the GeoJSON that `nav2_route` loads. Everything is in metres, in
the map's frame. The same from the command line:

    clearway roadmap map.yaml --radius 0.22 -o route_graph.geojson
"""

import json
import sys
from pathlib import Path

import cv2
import numpy as np

import navigation
import planner
from planner.roadmap.roadmap_export import to_geojson

MAP_YAML = """\
image: map.pgm
resolution: 0.05
origin: [-2.0, -1.5, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""


def write_map(folder: Path) -> Path:
    """Two rooms with a door of 1 m between them, 8 m by 5 m, and a table in one."""
    cells = np.full((100, 160), 254, np.uint8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 0
    cells[:40, 80:83] = cells[60:, 80:83] = 0
    cells[30:55, 112:134] = 0
    cv2.imwrite(str(folder / "map.pgm"), cells)
    (folder / "map.yaml").write_text(MAP_YAML, encoding="utf-8")
    return folder / "map.yaml"


def main(folder: Path) -> None:
    """Write map.yaml, map.pgm, route_graph.geojson and route_graph.svg."""
    scene = planner.load_scene(write_map(folder))
    roadmap = planner.build_roadmap(scene, radius=0.22)
    text = to_geojson(roadmap, frame="map")
    (folder / "route_graph.geojson").write_text(text, encoding="utf-8")
    kinds = [feature["geometry"]["type"] for feature in json.loads(text)["features"]]
    print(f"{kinds.count('Point')} nodes, {len(kinds) - kinds.count('Point')} edges")
    navigation.save_picture(folder / "route_graph.svg", scene, roadmap)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
