"""From a mask to edge points: contours followed, and edges located in the greys."""
