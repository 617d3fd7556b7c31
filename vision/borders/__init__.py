"""From a mask to the edge points of every border.

- `contours` follows all borders along the cracks between pixels (`contour_kernels`).
- `edge_profile_kernels` reads the light across each crack, and `edge_kernels` places the edge point
  where it crosses the half level.
- `staircase_kernels` finds points that follow the pixels in spite of grey.
"""
