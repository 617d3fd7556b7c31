"""Trajectory Planning: from a scene to a roadmap, a path and timed waypoints.

``__init__.pyi`` lists the public names. They are imported on first use, so that a module that
needs the scene's types only does not pay for the compiled kernels.
"""

from pathlib import Path as _FilePath

import lazy_loader

from planner.shared.kernel_cache import choose_kernel_cache

choose_kernel_cache(_FilePath(__file__).parent)

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
