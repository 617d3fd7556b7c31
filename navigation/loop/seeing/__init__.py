"""What the control loop sees: the eye, what it doubts, and who else is there."""
