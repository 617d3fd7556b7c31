"""The roadmap: what of the diagram a robot of some radius can drive, and the plans on it."""

from planner.roadmap.roadmap import Roadmap, build_roadmap

__all__ = ["Roadmap", "build_roadmap"]
