"""The checks of a finished outline against its border.

- `residual_kernels`: distance between border and outline.
- `loss_kernels` and `area_lost_kernels`: the area that edges lose, by edge and by border.
- `chord_kernels`: chords from point to point where no edges cover their border well enough.
- `stray_kernels`: the invariant that outline and border lie on each other.
"""
