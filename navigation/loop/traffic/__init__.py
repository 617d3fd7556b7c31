"""Who plans, and how much of their paths robots may drive: one alone, or several together."""
