"""Many variations of one simulated run, and what came of each."""
