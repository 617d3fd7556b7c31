"""Which of the regions of a mask are real: what speaks for a border, and what was left out."""
