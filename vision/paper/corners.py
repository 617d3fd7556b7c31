"""The paper's corner detector, by large small eigenvalues of the covariance matrix.

Rules and units
- Contours are the ordered border pixels of ``vision.borders.contours``, whole pixels, closed.
- The defaults are the paper's; a perfect digital line reaches 0.105, so ``extract`` uses residuals
  where it may (``vision.outline.fitting``).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vision.paper import corner_kernels as kernels

SUPPORT = 7
"""k: pixels to either side of the region of support (the paper, section 3.1)."""
THRESHOLD = 0.1
"""lambda_S above which a pixel is a corner (the paper, section 3.1)."""


def small_eigenvalues(
    contours: NDArray[np.int32], starts: NDArray[np.int64], support: int = SUPPORT
) -> NDArray[np.float64]:
    """lambda_S (equations 6 to 13) at every pixel of closed contours (n, 2): (n,). O(n)."""
    xs, ys = np.ascontiguousarray(contours[:, 0]), np.ascontiguousarray(contours[:, 1])
    values: NDArray[np.float64] = kernels.small_eigenvalues(xs, ys, starts, support)
    return values


def find_corners(
    contours: NDArray[np.int32],
    starts: NDArray[np.int64],
    support: int = SUPPORT,
    threshold: float = THRESHOLD,
) -> NDArray[np.bool_]:
    """Mask (n,) of corners of closed contours (n, 2), at least ``support`` apart."""
    values = small_eigenvalues(contours, starts, support)
    corners: NDArray[np.bool_] = kernels.strongest_apart(values, starts, support, threshold)
    return corners
