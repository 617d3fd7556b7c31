"""The simulated arena: its geometry, its camera and its robot."""
