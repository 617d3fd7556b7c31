"""Modules shared by the kernels, checks of arguments, and numbers and their wording.

- ``kernel_cache.py`` chooses where compiled kernels are kept, before numba is imported.
- ``kernel_locator.py`` finds kernels that still fit, or were shipped, by ``source_stamp.py``.
- ``processor.py`` chooses the processor that kernels are compiled for.
- ``search_clock.py`` times searches without the time of compilation.
- ``arguments.py`` checks what comes in from outside.
- ``angles.py`` wraps angles; ``figures.py`` writes numbers in sentences.
"""
