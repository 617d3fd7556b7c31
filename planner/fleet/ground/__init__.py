"""The graph that the robots share, with the exact clearance of each of its edges.

- ``shared_graph.py`` collects places from the roadmap's chains, the robots' paths and a lattice,
  and joins near ones by edges.
- ``clearance_kernels.py`` finds the near pairs and measures each edge's clearance.
"""
