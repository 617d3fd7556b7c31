"""Places where two edges meet.

- `joint_kernels` fits the edges between their breaks, and `crossing_kernels` intersects neighbours.
- `blurred_corner_kernels` is the effect of blur on a corner.
- `fillet_kernels`, `wall_end_kernels` and `missed_arc_kernels` find rounded corners, the short ends
  of walls and bent lines.
- `edit_search_kernels` applies the edits of `edit_kernels` until none lowers the cost.
"""
