"""The line itself: its pace, its clock, and what is wrong with it."""
