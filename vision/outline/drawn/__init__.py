"""Outlines of pictures without grey, which must separate obstacle pixels from free ones.

- `separation_kernels` checks that finished edges do, and `lost_run_kernels` finds runs of lost
  cracks.
- `joint_relaxation_kernels` moves a chain of edges until it passes between the pixels.
- `merging_kernels` replaces runs of edges by the line or arc of `merged_edge_kernels`.
- `separating_chord_kernels` puts chords where edges still do not separate the pixels.
"""
