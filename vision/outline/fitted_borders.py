"""Fitted outlines: the edges of every border, and the codes of their kinds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

# defined: kinds of an edge
LINE: Final = 0
# defined: the same
ARC_CW: Final = 1
# defined: the same
ARC_CCW: Final = 2
# defined: kinds of a border
POLYGON: Final = 0
# defined: the same
WHOLE_CIRCLE: Final = 1
TINY_BORDER: Final = 2
"""Too few points for a fit: defined."""
FEWEST_LINES: Final = 3
"""Lines that enclose something: derived, two do not."""


@dataclass(frozen=True, slots=True)
class FittedBorders:
    """Lines, arcs and circles of every border, from ``vision.outline.fitting``.

    ``border_kind`` (b,): POLYGON, WHOLE_CIRCLE or TINY_BORDER. ``edge_starts`` (b + 1,). ``kind``
    (k,): LINE, ARC_CW or ARC_CCW. ``data`` (k, 6): first point x, y; centre x, y and radius of an
    arc or circle; the border's rms deviation in pixels.
    """

    border_kind: NDArray[np.int8]
    edge_starts: NDArray[np.int64]
    kind: NDArray[np.int8]
    data: NDArray[np.float64]

    def stretched(self, stretches: NDArray[np.float64]) -> FittedBorders:
        """The same with each border's coordinates times a factor (b,); deviations stay."""
        data = self.data.copy()
        data[:, :5] *= np.repeat(stretches, np.diff(self.edge_starts))[:, None]
        return FittedBorders(self.border_kind, self.edge_starts, self.kind, data)
