"""Approximate generalized Voronoi diagram of borders: mesh, vertices, chains, validity.

- ``mesh.py`` triangulates the generators, and solves and refines the mesh: ``mesh_kernels.py``
  finds centres and the free part, ``vertex_kernels.py`` valid edges and, with
  ``bisector_kernels.py``, exact vertices.
- ``chains/`` traces chains along the valid edges and bends them onto the bisectors.
- ``agvd.py`` is the interface, with its kernels in ``agvd_kernels.py``; ``diagram_arrays.py``
  defines the arrays that kernels share; ``bisectors.py`` names the curves of edges.
- ``update.py`` and ``update_kernels.py`` change it if a few objects differ.
"""
