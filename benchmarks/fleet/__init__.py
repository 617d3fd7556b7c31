"""Several robots: beside Continuous-CBS, among obstacles, and driven through the daemon."""
