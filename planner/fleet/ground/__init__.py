"""The graph that the robots share, with the exact clearance of each of its edges."""
