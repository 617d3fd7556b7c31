"""How compiled kernels that allocate nothing are built.

Rules and units
- ``_nrt``: what allocates nothing needs no count of references, which would cost two atomic
  additions for every array of every call. Such a kernel may call only its like.
- ``error_model``: a division is not looked at for zero, which would keep loops from working on
  several points at a time; divisors are kept from zero where they are made.
- ``fastmath``: sums may be added in any order; no number is ever NaN.
"""

from __future__ import annotations

from typing import Any

LEAF: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}
"""A kernel that allocates nothing and calls only its like."""
SUMS: dict[str, Any] = {**LEAF, "fastmath": {"reassoc", "contract", "nsz", "nnan", "arcp"}}
"""The same, for loops over many points."""
