"""The audit of a route graph against a map: exact clearances, and what is wrong with the graph.

- ``audit`` is the interface; ``findings`` lists the kinds of findings.
- ``edge_lines`` lays the edges out as lines, which `planner.borders.ground` measures; ``unsafe``
  judges what is in and near obstacles and zones, with ``unknown_lengths`` for unseen cells.
- ``slow_zones`` compares speed limits, ``turns`` finds tight turns, ``passing`` stretches on which
  two robots cannot pass.
- ``nearby`` finds edges that cross and nodes on other edges, ``structure`` looks at ids, doubles
  and reachability, ``goals`` plans to goals.
- ``frame_search`` looks for the transform (``frame_fit``) that puts a lost graph onto its map.
- ``coverage`` measures how much of the free space is near the graph.
"""
