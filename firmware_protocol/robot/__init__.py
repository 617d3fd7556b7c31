"""The robot's end of the line as this computer runs it: ``micropython.clearway`` in SI units."""
