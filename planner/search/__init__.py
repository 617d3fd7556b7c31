"""Searches along chains, around corners, and through several stations.

- ``search_kernels.py`` makes the chains a graph with costs; ``attach_kernels.py`` attaches
  stations, ``route_kernels.py`` searches and lays out a route, ``alternative_kernels.py`` the
  k cheapest; ``chain_search.py`` is their interface.
- ``shortest.py`` with ``tangent_kernels.py`` finds the exact shortest path.
- ``homotopy.py`` with ``homotopy_kernels.py`` distinguishes paths by the sides they take.
- ``tour.py`` with ``tour_kernels.py`` orders the stations.
"""
