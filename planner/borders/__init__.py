"""Borders as primitives: joined pieces, exact distances, points within objects, generators.

- ``corner_point_kernels.py`` joins the flat primitives and finds the corners that need a point.
- ``border_kernels.py`` makes pieces of them, or patches those of a slightly different scene;
  ``border_arrays.py`` defines the arrays that kernels pass on.
- ``box_tree_kernels.py`` finds the nearest piece, ``clear_kernels.py`` checks that lines keep a
  distance, ``inside_kernels.py`` finds the objects around a point, and ``overlap_kernels.py``
  the objects that meet.
- ``generator_kernels.py`` places points along the borders; ``generators.py`` is the interface
  to all of this.
- ``ground.py`` measures points and lines against the borders of a scene, with or without bounds.
- ``free_rays.py`` finds the nearest free places around a place.
- ``polyline.py`` and ``polyline_kernels.py`` measure polylines and reduce their vertices.
"""
