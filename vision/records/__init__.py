"""From fitted borders to the paper's records P, S, C, A and L.

- `placement` puts them in pixels, or on the floor in metres.
- `records` makes them, with `record_kernels` and `bulk_records`; `thin_curves` adds curved lines
  one pixel wide.
- `clipping` cuts records at the picture's edge, and `unseen` adds ground that no camera sees.
"""
