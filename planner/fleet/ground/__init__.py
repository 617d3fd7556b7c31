"""The graph that the robots share, with the exact clearance of each of its edges.

- ``places`` collects places from the roadmap's chains, the robots' paths and a lattice.
- ``clearance_kernels`` finds the near pairs and measures each edge's clearance.
"""
