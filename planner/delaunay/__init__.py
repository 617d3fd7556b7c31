"""Exact Delaunay triangulation of points, and its dual, the Voronoi diagram.

- ``site_order_kernels.py`` scales the sites and orders them for insertion.
- ``insertion_kernels.py`` inserts them, ``removal_kernels.py`` removes some;
  ``triangle_kernels.py`` names triangles and half-edges.
- ``predicate_kernels.py`` decides on which side a site lies, by ``exact_kernels.py`` if in doubt.
- ``diagram_kernels.py`` makes the triangulation a Voronoi diagram, and proves it.
- ``voronoi_diagram.py`` is the interface; ``half_edges.py`` is its result.
"""
