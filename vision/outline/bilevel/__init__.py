"""Outlines of bilevel pictures, which must separate obstacle pixels from free ones.

Two facts: a picture is `crisp` if its edges have no grey between (measured over all of them), and
`bilevel` if it is crisp or all its borders run between the same two values of grey. Crisp edges are
fitted by other tolerances, bilevel ones must pass between the pixels as well.

- `separation_kernels` checks that finished edges do, and `lost_run_kernels` finds runs of lost
  cracks.
- `joint_relaxation_kernels` moves a chain of edges until it passes between the pixels.
- `merging_kernels` replaces runs of edges by the line or arc of `merged_edge_kernels`.
- `separating_chord_kernels` puts chords where edges still do not separate the pixels.
"""
