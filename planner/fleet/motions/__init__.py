"""Discs on straight lines: when they touch, and the earliest arrival among those that move."""
