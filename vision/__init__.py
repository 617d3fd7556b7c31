"""Global Vision: from a picture to a scene and robot poses.

The public names (``__init__.pyi``) are imported on first use, so no part pays for the others'
kernels.

- `camera` delivers frames; `calibrate` makes the `calibration` that maps them to the floor.
- `pipeline` turns a picture into a scene: `binarise`, then `borders`, `outline` (or `paper`) and
  `records`; `doubts` adds remarks, `picture_error` has ``PictureError``.
- `watch` finds what changed between two pictures; `markers` finds and follows robots.
- `joined` unites several cameras over one arena; `quality` measures what a camera delivers.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
