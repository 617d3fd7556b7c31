"""The audit of a route graph against a map: exact clearances, and what is wrong with the graph.

- ``audit.py`` is the interface; ``findings.py`` lists the kinds of findings with their severity,
  sentence and cure.
- ``edge_lines.py`` lays the edges out as lines, which `planner.borders.ground` measures,
  ``unsafe.py`` judges what is in and near obstacles and zones, and ``unknown_lengths.py`` finds
  the parts in unseen cells.
- ``slow_zones.py`` compares speed limits, ``turns.py`` and ``passing.py`` look for tight turns and
  for stretches on which two robots cannot pass.
- ``nearby.py`` finds edges that cross and nodes on other edges, ``structure.py`` looks at ids,
  doubles and reachability, ``goals.py`` plans to goals.
- ``frame_search.py`` looks for the transform that puts a lost graph onto its map, of
  ``frame_fit.py``.
- ``coverage.py`` measures how much of the free space is near the graph.
"""
