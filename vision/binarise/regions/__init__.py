"""The check of a mask's regions: which of them are real, and which are missing.

- `edge_evidence` finds the level that the picture's edges speak for, and the obstacles that the
  level taken has left out; its kernels measure the steps across a border.
- `floor_pattern` recognises a floor with a pattern of its own.
- `judge` decides for each region, by the steps across its border.
"""
