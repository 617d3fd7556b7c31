"""Trajectory planning: from a scene to a roadmap, a path and timed waypoints.

- ``formats`` reads a scene; ``scene`` defines its obstacles and bounds.
- ``borders`` places generators along the borders, ``delaunay`` triangulates them, ``diagram``
  solves the generalized Voronoi diagram, ``roadmap`` clips it for a robot.
- ``search`` and ``route`` plan on it; ``path`` holds the answers. ``zones`` adds rules to it.
- ``motion`` times a path, ``fleet`` plans for several robots; ``samples`` are inputs to try.
- ``graph_files`` reads and writes route graphs, ``graph_audit`` checks and ``graph_repair`` repairs
  them.

``__init__.pyi`` lists the public names. They are imported on first use, so that modules that need
only the scene's types do not load the compiled kernels.
"""

from pathlib import Path as _FilePath

import lazy_loader

from planner.shared.kernel_cache import choose_kernel_cache

choose_kernel_cache(_FilePath(__file__).parent)

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
