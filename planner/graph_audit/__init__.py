"""The audit of a route graph against a map: exact clearances, and what is wrong with the graph.

- ``audit.py`` is the interface; ``findings.py`` lists the kinds of findings with their severity,
  sentence and cure.
- ``edge_lines.py`` lays the edges out as lines, which `planner.borders.ground` measures,
  ``unknown_lengths.py`` finds those in unseen cells,
  ``nearby.py`` finds edges that cross and nodes on other edges, ``structure.py`` looks at ids,
  doubles and reachability.
"""
