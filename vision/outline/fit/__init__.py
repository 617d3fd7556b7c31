"""The fit of one edge, and its cost.

- `moment_kernels`: lines and circles from sums over a stretch of a border.
- `edge_shape_kernels`: the best line or circle of a stretch, at the prices of `edge_prices`.
- `separating_fit_kernels`: lines and circles that pass between the pixels of a picture without
  grey.
- `outline_kernels`: the finished edges of a closed outline.
"""
