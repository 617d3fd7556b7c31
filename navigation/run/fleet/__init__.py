"""A run of several robots: what it is connected to, in real and in virtual time, and its report."""
