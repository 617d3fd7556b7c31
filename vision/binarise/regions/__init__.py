"""The check of a mask's regions: which of them are real, and which are missing.

- `edge_evidence` finds the level that edges support, and the obstacles that a level leaves out; its
  kernels measure steps across borders.
- `floor_pattern` recognises a floor with a pattern of its own.
- `judge` decides for each region, by the steps across its border.
"""
