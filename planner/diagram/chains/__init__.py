"""Chains: traced along valid edges, bent onto bisectors, kept where nothing has changed.

- ``trace_kernels.py`` joins valid edges to chains.
- ``bisector_trace.py`` allocates the new chains' arrays, and calls ``chain_kernels.py``.
- ``chain_kernels.py`` finds each chain's stations, and measures the finished chains.
- Between stations, ``kept_run_kernels.py`` finds unchanged runs; ``bend_kernels.py`` bends the
  others onto their bisectors.
"""
