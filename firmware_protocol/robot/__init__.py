"""The robot's end of the link, and what it does with waypoints: the reference of the C firmware."""
