"""Typed numbers and answers that kernels take.

Numba compiles a kernel again for every literal that it is passed (see
``planner.scene.compile_options``), but not for these.
"""

from __future__ import annotations

from typing import Any

import numpy as np

ZERO: Any = np.int64(0)
ONE: Any = np.int64(1)
NO: Any = np.bool_(False)
YES: Any = np.bool_(True)
