"""The running program, in virtual and in real time: ``python -m benchmarks.daemon``."""
