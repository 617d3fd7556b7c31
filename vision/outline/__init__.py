"""From edge points to edges: lines, arcs and circles of every border."""
