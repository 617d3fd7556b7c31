"""Typed numbers and answers that kernels take.

Rules
- Numba compiles a kernel, with everything below it, again for every literal that it is passed (see
  ``planner.scene.compile_options``). These are ordinary numbers to it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

NONE: Any = np.int64(0)
ONE: Any = np.int64(1)
NO: Any = np.bool_(False)
YES: Any = np.bool_(True)
