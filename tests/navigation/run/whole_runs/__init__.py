"""Runs of the whole program in virtual time, from the configuration to the exit code."""
