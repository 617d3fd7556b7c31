"""The approximate generalized Voronoi diagram of borders: mesh, vertices, chains, validity."""
