"""Zones, judged by the simulation's truth: ``python -m benchmarks.zones``.

- ``random_runs.py`` makes runs of one to six robots among random zones, some drawn meanwhile.
- ``judge.py`` looks for violations on the true tracks, with plain geometry of its own.
- ``__main__.py`` counts them, and times a zone from its drawing to the new plan.
"""
