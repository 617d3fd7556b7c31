"""The names of ``vision``, ``planner`` and ``navigation`` that ``clearway`` has, too.

In a module beside ``__init__.pyi``, because lazy-loader finds names of its own package only.
"""

from navigation import save_picture
from planner import NoPath, Path, Roadmap, Scene, build_roadmap, load_scene, sample, time_path
from vision import extract

__all__ = [
    "NoPath",
    "Path",
    "Roadmap",
    "Scene",
    "build_roadmap",
    "extract",
    "load_scene",
    "sample",
    "save_picture",
    "time_path",
]
