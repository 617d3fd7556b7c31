"""What a mission is and what the robot may do next: decisions only, no clock, no device."""
