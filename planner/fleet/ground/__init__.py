"""The graph that the robots share, with the exact clearance of each of its edges.

- ``shared_graph`` joins places of the roadmap's chains, the robots' paths and a lattice.
- ``clearance_kernels`` finds the near pairs and measures each edge's clearance.
- ``zone_edges`` leaves each robot the edges that the zones allow it, and their costs.
"""
