"""The robot's end for MicroPython boards: the folder ``clearway`` and a file for each board."""
