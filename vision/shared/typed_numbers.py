"""Numbers and answers that kernels are handed as they are, typed.

Rules
- Numba compiles a kernel once more for every literal that it is handed (see
  ``planner.scene.compile_options``), with all that is below it. These are numbers as any other.
"""

from __future__ import annotations

import numpy as np

NONE, ONE = np.int64(0), np.int64(1)
NO, YES = np.bool_(False), np.bool_(True)
