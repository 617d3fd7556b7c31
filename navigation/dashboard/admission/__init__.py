"""Who may look, who may order, and how many there may be."""
