"""From edges to the paper's records P, S, C, A and L."""
