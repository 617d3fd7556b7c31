"""Searches along chains, around corners, and through several stations.

- ``chain_graph_kernels.py`` makes the chains a graph with costs; ``attach_kernels.py`` attaches
  stations, ``route_search_kernels.py`` searches and lays out a route, ``alternative_kernels.py``
  the k cheapest; ``chain_search.py`` is their interface.
- ``tangent_search.py`` with ``tangent_kernels.py`` finds the exact shortest path.
- ``homotopy.py`` with ``homotopy_kernels.py`` distinguishes paths by their sides.
- ``tour.py`` with ``tour_kernels.py`` orders the stations.
"""
