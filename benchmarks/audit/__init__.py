"""The audit of route graphs, judged: ``python -m benchmarks.audit``.

- ``planted.py`` makes random maps and graphs, sound ones with faults planted in them.
- ``judge.py`` decides each kind of finding without the planner: by distance transforms at a
  quarter of a cell with their error bounds, and by looking at all pairs.
- ``__main__.py`` counts what the audit finds, misses and invents, and times a large map.
"""
