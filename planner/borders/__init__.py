"""Borders as primitives: their exact distances, the box tree over them, points within."""
