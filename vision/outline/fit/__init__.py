"""What fits an edge: moments, circles, separating lines, and what an edge costs."""
