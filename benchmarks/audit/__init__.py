"""The audit of route graphs, judged: ``python -m benchmarks.audit``.

- ``planted.py`` makes random maps and graphs, sound ones with faults planted in them.
- ``judge.py`` decides each kind of finding without the planner: by the distance transforms of
  ``distances.py`` with their error bounds, and by looking at all pairs; ``turns.py`` judges turns,
  ``stretches.py`` where two robots cannot pass.
- ``frames.py`` puts graphs into other frames, ``repairs.py`` repairs those with faults.
- ``__main__.py`` counts what the audit finds, misses and invents, and times a large map.
- ``gallery.py`` audits the graphs that Nav2 ships, and our roadmaps of the same maps.
"""
