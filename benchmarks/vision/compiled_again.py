"""Kernels compiled again, for numbers and functions that a benchmark has changed.

Numba keeps a kernel's code by its source and its types: it does not see that a number or a function
which was compiled into it is another one. A folder without kernels is therefore made the cache.
"""

from __future__ import annotations

import sys

from numba.extending import is_jitted

from planner.shared.kernel_locator import CONFIG


def compile_again(package: str, folder: str) -> None:
    """Keep the kernels of a package, and all that are defined later, in an empty folder.

    Of the package's kernels none may have been called in this process.
    """
    CONFIG.CACHE_DIR = folder
    for name in [name for name in sys.modules if name.startswith(package)]:
        for kernel in vars(sys.modules[name]).values():
            if is_jitted(kernel):
                kernel.enable_caching()
