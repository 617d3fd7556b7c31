"""Lines, arcs and circles from edge points, border by border.

1. `limit_kernels`: limits on what an outline may miss, from the picture's noise, blur and greys.
2. `canonical_frame_kernels`: turns each border, so that mirrored ones get mirrored outlines.
3. `whole_circle_kernels`: finds borders that are one circle.
4. `seed_kernels` and `partition_kernels`: possible breaks, and the cheapest partition.
5. `corners/`: corners, wall ends and fillets where edges meet, with the prices and fits of `fit/`.
6. `bilevel/`: outlines that separate the pixels of pictures of two grey values.
7. `check/`: checks every outline against its border; `thin_walls` keeps walls that a fit would cut.

`fitting` (`fitting_kernels`, and `separated_border_kernels` for pictures of two grey values) runs
them, with the types of `outline_types` and the memory of `fitting_memory`, into `fitted_borders`.
"""
