"""From a request to a path: preferences, margin, the taut line, and why there is no path."""
