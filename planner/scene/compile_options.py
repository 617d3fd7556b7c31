"""Options by which the kernels are compiled.

Rules
- A borrowing kernel makes and returns no array, nor a part of one; it calls only borrowing
  kernels. Elsewhere numba counts references to passed arrays, with atomic instructions, and
  omits few of them in loops: a third of the diagram's time. The caller of a borrowing kernel
  holds its arrays meanwhile, so nothing needs counting.
- Kernels have no C wrappers: these are unused, and took a twentieth of the compile time.
- Numba compiles a kernel with all that it calls, and again within each caller. A large kernel with
  one caller, of the same options, is therefore ``inline="always"``: numba writes it into its
  caller first. This applies to 30 kernels and saves a sixth of the compile time
  (``python -m benchmarks.start.compile``); with 218 kernels it made compiling slower, as numba's
  own passes take more than twice as long for a function of twice the size.
- No kernel assigns an array to a part of another, not even a row: numba's message for arrays that
  do not fit, with all that it needs to write numbers as text, would be linked into it and into
  every kernel above. Kernels copy in loops, or by ``put_rows``.
- A kernel is compiled once for every combination of argument types: a literal, or a number of
  another width, costs as much as one more kernel.
- ``error_model``: divisors are not tested for zero, which would prevent vectorised loops; they
  are kept from zero where they are made.
- ``fastmath``: sums may be added in any order; no number is ever NaN. A kernel that does not state
  it inherits it from its first caller, so that the last bits would depend on the order of
  compilation: all others say no.
"""

from __future__ import annotations

from typing import Any

from numba.core.options import DefaultOptions

from planner.shared.kernel_locator import prepare_kernels

prepare_kernels()

OWNING: dict[str, Any] = {"cache": True, "nogil": True, "fastmath": False}
"""Options of ``njit`` for a kernel that makes arrays."""
if hasattr(DefaultOptions, "no_cfunc_wrapper"):
    OWNING["no_cfunc_wrapper"] = True
BORROWING: dict[str, Any] = dict(OWNING)
"""Options of ``njit`` for a kernel that only borrows its arrays."""
if hasattr(DefaultOptions, "_nrt"):  # numba without it counts: slower, with equal answers
    BORROWING["_nrt"] = False
LEAF: dict[str, Any] = {**BORROWING, "error_model": "numpy"}
"""The same, and divisions are not looked at for zero."""
SUMS: dict[str, Any] = {**LEAF, "fastmath": {"reassoc", "contract", "nsz", "nnan", "arcp"}}
"""The same, for loops over many points."""
