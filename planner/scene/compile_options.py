"""How the kernels are compiled, in one place.

Rules
- A borrowing kernel makes no array and returns none, not even a part of one; it calls borrowing
  kernels only. Numba counts references to arrays wherever they are passed on, with atomic
  instructions, and leaves few of them out where there are loops: a third of the diagram's time.
  Whoever calls a borrowing kernel holds its arrays meanwhile, so that nothing needs to be counted
  there.
- No kernel has a wrapper for C, which nobody calls and which took a twentieth of the time that
  compiling takes.
- Numba compiles a kernel together with all that it calls, and once more within each that calls it.
  A large kernel with one caller, of the same options, is therefore ``inline="always"``: numba
  writes it into its caller first. That is 29 kernels and a sixth of the time that compiling takes
  (``python -m benchmarks.start.compile``); of 218 it made compiling slower, as numba's own passes
  take more than twice as long for a function of twice the size.
- A kernel is compiled once for every combination of types that it is called with: what is passed
  on as a literal, or as a number of another width, costs as much as one more kernel.
- ``error_model``: a division is not looked at for zero, which would keep loops from working on
  several points at a time; divisors are kept from zero where they are made.
- ``fastmath``: sums may be added in any order; no number is ever NaN. Where a kernel does not say,
  numba lets it inherit this from the kernel that happens to call it first, so that the last bits
  would depend on what was compiled before what: all others say no.
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
if hasattr(DefaultOptions, "_nrt"):  # a numba without it would count, slower, with equal answers
    BORROWING["_nrt"] = False
LEAF: dict[str, Any] = {**BORROWING, "error_model": "numpy"}
"""The same, and divisions are not looked at for zero."""
SUMS: dict[str, Any] = {**LEAF, "fastmath": {"reassoc", "contract", "nsz", "nnan", "arcp"}}
"""The same, for loops over many points."""
