"""The serial line to the robot: its port, its thread, and what is known of the robot."""
