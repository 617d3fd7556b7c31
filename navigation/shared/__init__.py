"""Small things that every part of the running program may need."""
