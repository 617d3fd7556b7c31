"""Numbers and answers that kernels are handed as they are, typed.

Rules
- Numba compiles a kernel once more for every literal that it is handed (see
  ``planner.scene.compile_options``), with all that is below it. These are numbers as any other.
"""

from __future__ import annotations

from typing import Any

import numpy as np

NONE: Any = np.int64(0)
ONE: Any = np.int64(1)
NO: Any = np.bool_(False)
YES: Any = np.bool_(True)
