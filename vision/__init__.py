"""Global Vision: from a picture to a scene and robot poses.

``__init__.pyi`` lists the public names. They are imported on first use, so that a module that
needs one part does not pay for the compiled kernels of the others.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
