"""A ROS map to a graph for Nav2's route server.

    python examples/ros_map_to_nav2.py [FOLDER]

Builds the roadmap of a map as `map_saver` writes it, of two rooms with a door between them, for a
robot with a radius of 0.22 m, and writes it as the GeoJSON that `nav2_route` loads. Everything is
in metres, in the map's frame. The same from the command line:

    clearway sample rooms
    clearway roadmap rooms.yaml --radius 0.22 -o route_graph.geojson
"""

import json
import sys
from pathlib import Path

import navigation
import planner


def main(folder: Path) -> None:
    """Write route_graph.geojson and route_graph.svg."""
    scene = planner.load_scene(planner.sample("rooms"))  # or the YAML of a map of yours
    roadmap = planner.build_roadmap(scene, radius=0.22)
    graph = folder / "route_graph.geojson"
    roadmap.save(graph, frame="map")
    features = json.loads(graph.read_text(encoding="utf-8"))["features"]
    kinds = [feature["geometry"]["type"] for feature in features]
    print(f"{kinds.count('Point')} nodes, {len(kinds) - kinds.count('Point')} edges")
    navigation.save_picture(folder / "route_graph.svg", scene, roadmap)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
