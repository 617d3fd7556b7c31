"""From grey values to a mask of obstacles, and the one list of the methods that there are.

``vision.binarise.binarise`` has a function for each; configuration and command line offer what
stands here.
"""

from __future__ import annotations

from typing import Final, Literal, TypeAlias, get_args

Method: TypeAlias = Literal["auto", "otsu", "fixed", "adaptive", "background"]
Polarity: TypeAlias = Literal["dark", "light", "auto"]
METHODS: Final[tuple[Method, ...]] = get_args(Method)
POLARITIES: Final[tuple[Polarity, ...]] = get_args(Polarity)
ONE_LEVEL: Final[tuple[Method, ...]] = ("otsu", "fixed")
"""Methods with one level for the whole picture."""
