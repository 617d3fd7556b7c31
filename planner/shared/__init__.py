"""Modules shared by the kernels, checks of arguments, and numbers and their wording.

- ``kernel_cache`` chooses where compiled kernels are kept, before numba is imported.
- ``kernel_locator`` finds kernels that still fit, or were shipped, by ``source_stamp``.
- ``processor`` chooses the processor that kernels are compiled for.
- ``search_clock`` times searches without the time of compilation.
- ``arguments`` checks what comes in from outside.
- ``angles`` wraps angles; ``figures`` writes numbers in sentences.
"""
