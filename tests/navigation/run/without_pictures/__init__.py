"""Runs that draw no picture, beside those that do."""
