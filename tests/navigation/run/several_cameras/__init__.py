"""Runs with several cameras, in virtual time."""
