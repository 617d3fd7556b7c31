"""The exact Delaunay triangulation of points, and the Voronoi diagram that is its dual."""
