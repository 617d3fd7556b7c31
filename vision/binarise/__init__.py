"""From grey values to a mask of obstacles.

- `grey_picture` makes a picture grey, measures it (`binarise_kernels`) and compares it with a
  level, smoothed if noisy (`smoothing_kernels`) unless `humps` shows fine structure.
- `grey_classes` finds the two classes of grey values, `unresolved` structure too fine for any
  level, and `light_surface` the ground's light.
- `binarise` has the methods; `regions/` checks which regions of a mask are real.
- `colour` adds obstacles that differ from the floor in colour only.
- `earlier_level` checks an earlier picture's level on a later picture.
"""

from __future__ import annotations

from typing import Final, Literal, TypeAlias, get_args

Method: TypeAlias = Literal["auto", "otsu", "fixed", "adaptive", "background"]
Polarity: TypeAlias = Literal["dark", "light", "auto"]
METHODS: Final[tuple[Method, ...]] = get_args(Method)
POLARITIES: Final[tuple[Polarity, ...]] = get_args(Polarity)
ONE_LEVEL: Final[tuple[Method, ...]] = ("otsu", "fixed")
"""Methods with one level for the whole picture."""
