"""The emulated machine: the computer itself, its snapshot, and what is plugged into it."""
