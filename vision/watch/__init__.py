"""What changed between two pictures, and the scene brought up to date."""
