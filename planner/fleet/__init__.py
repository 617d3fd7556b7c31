"""Several robots on one roadmap: timed tracks, no two of which ever touch."""
